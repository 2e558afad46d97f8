// EngineConfig::drawing.looks.edges: which pixels lines cover, against rays at points of the edges; by OpenGL and by
// the processor.
#include "sightline/gpuprims/internal/edges.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/image_rays.h"
#include "sightline/core/mesh_edges.h"
#include "sightline/core/scene.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/raytrace/tracer.h"
#include "sightline/tests/core/primitive_samples.h"
#include "sightline/tests/engine/drawing_modes.h"

namespace sightline::tests::edges_test {
namespace {

using core::dvec2;
using core::dvec3;
using engine::EdgeChoice;
using engine::Engine;
using engine::EngineConfig;
using engine::Renderer;

constexpr int kWidth = 320, kHeight = 220;
constexpr float kLineWidth = 2.0f;
constexpr double kReach = 0.5 * double(kLineWidth) + 0.5;  // pixels from a line to the middle of those it colours

/// Large solids that overlap, and meshes among them.
void furnish(core::Scene& scene, unsigned seed) {
  Random random(seed);
  const auto length = [&] { return float(uniform(random, 0.8, 3.0)); };
  const auto shift = [&] { return float(uniform(random, -0.5, 0.5)); };
  const auto angle = [&] { return float(uniform(random, 1.0, 5.0)); };
  const core::MeshId block = scene.add_mesh(gpuprims::tessellate(core::Box{2, 1, 1.5f}, {})).value();
  const core::MeshId rod =
      scene.add_mesh(gpuprims::tessellate(core::Cylinder{0.7f, 3}, {.fixed_segments = 20})).value();
  for (int i = 0; i < 24; ++i) {
    core::Affine place = core::translation({uniform(random, -4, 4), uniform(random, -4, 4), uniform(random, -3, 3)});
    const core::dvec3 axis = glm::normalize(core::dvec3(uniform(random, -1, 1), uniform(random, -1, 1), 0.5));
    const core::dvec3 side = glm::normalize(glm::cross(axis, core::dvec3(0.3, 0.9, 0.2)));
    place.linear = {side, glm::cross(axis, side), axis};
    if (i % 4 == 3) {
      scene.add_mesh_instance(scene.root(), i % 8 == 3 ? block : rod, place);
      continue;
    }
    constexpr core::Kind kKinds[] = {core::Kind::kBox,     core::Kind::kCylinder,         core::Kind::kSnout,
                                     core::Kind::kPyramid, core::Kind::kEllipticalDish,   core::Kind::kSphere,
                                     core::Kind::kBox,     core::Kind::kRectangularTorus, core::Kind::kCylinder};
    scene.add_primitive(scene.root(), primitive_of(kKinds[i % 9], length, shift, angle), place);
  }
}

core::View at(double turn) {
  const dvec3 eye = 12.0 * dvec3(std::cos(turn), std::sin(turn), 0.45);
  return *core::View::perspective({eye, {0, 0, 0}, {0, 0, 1}}, 0.8, double(kWidth) / kHeight, 0.1);
}
core::View parallel(double turn) {
  const dvec3 eye = 20.0 * dvec3(std::cos(turn), std::sin(turn), 0.6);
  return *core::View::orthographic({eye, {0, 0, 0}, {0, 0, 1}}, 9.0, double(kWidth) / kHeight, 0.1, 60.0);
}

/// Points of all edges of a scene, in the world, hardly a third of a pixel apart.
std::vector<dvec3> points_of(const core::Snapshot& snapshot) {
  std::vector<dvec3> points;
  const auto add_segment = [&](const dvec3& from, const dvec3& to) {
    const int steps = 2 + int(glm::distance(from, to) / 0.01);
    for (int i = 0; i <= steps; ++i) points.push_back(glm::mix(from, to, double(i) / steps));
  };
  for (core::Slot slot = 0; slot < snapshot.size(); ++slot) {
    const core::Affine placed = snapshot.world_from_item(slot);
    if (snapshot.kind(slot) == core::Kind::kMesh) {
      const core::Mesh& mesh = snapshot.mesh(slot);
      for (const auto& [a, b] : core::edges_of(mesh))
        add_segment(core::transform_point(placed, dvec3(mesh.positions[a])),
                    core::transform_point(placed, dvec3(mesh.positions[b])));
      continue;
    }
    for (const gpuprims::PrimitiveEdge& edge : gpuprims::edges_of(snapshot.primitive(slot), placed)) {
      const int steps = 2 + int(edge.sweep * std::max(glm::length(edge.u), glm::length(edge.v)) / 0.01);
      for (int i = 0; i <= steps; ++i) {
        const double t = edge.sweep * i / steps;
        points.push_back(edge.centre + std::cos(t) * edge.u + std::sin(t) * edge.v);
      }
    }
  }
  return points;
}

/// What lines may and must cover.
class Twin {
 public:
  Twin(const core::Snapshot& snapshot, const raytrace::Tracer& tracer, const core::View& view)
      : tracer_(tracer),
        view_(view),
        rays_(*core::ImageRays::create(view, kWidth, kHeight)),
        filter_(raytrace::filter_of(view)),
        may_(std::size_t(kWidth * kHeight)),
        must_(may_.size()) {
    for (const dvec3& point : points_of(snapshot)) add(point);
  }
  bool may(std::size_t pixel) const { return may_[pixel]; }
  bool must(std::size_t pixel) const { return must_[pixel]; }

 private:
  /// By how many widths of a pixel what a ray through a place meets lies before a point; far below 0 where nothing is.
  double before(const dvec2& place, const dvec3& point) const {
    const core::Ray ray = rays_.through(place.x, place.y);
    const auto hit = tracer_.first(ray, filter_);
    if (!hit || hit->slot == core::kNone) return -1e9;
    const double along = glm::dot(point - ray.origin, ray.direction);
    const double pixel = view_.orthographic() ? 2.0 / (view_.clip_from_eye()[1][1] * kHeight)
                                              : along * 2.0 / (view_.clip_from_eye()[1][1] * kHeight);
    return (along - hit->t) / pixel;
  }
  bool kept(const dvec3& point) const {
    const auto inside = [&](const core::Plane& p) { return glm::dot(p.normal, point) + p.offset >= 0.0; };
    return std::all_of(view_.sections.begin(), view_.sections.end(), inside);
  }
  void add(const dvec3& point) {
    const core::dvec4 clip = view_.clip_from_world() * core::dvec4(point, 1.0);
    if (!(clip.w > 0.0) || !kept(point)) return;
    const dvec2 place((0.5 + 0.5 * clip.x / clip.w) * kWidth, (0.5 - 0.5 * clip.y / clip.w) * kHeight);
    const double to_border = std::min({place.x, place.y, kWidth - place.x, kHeight - place.y});
    if (to_border < -3.0) return;
    const double here = before(place, point);
    double nearest = here, farthest = here;
    for (int i = 0; i < 8; ++i) {
      const dvec2 towards(std::cos(i * std::numbers::pi / 4), std::sin(i * std::numbers::pi / 4));
      nearest = std::max(nearest, before(place + 1.5 * towards, point));
      farthest = std::min(farthest, before(place + 3.0 * towards, point));
    }
    if (farthest < 1.0) mark(place, kReach + 0.2, may_);
    // Nothing lies before it but surfaces that lean by as much as 75 degrees.
    if (to_border > 2.0 && nearest < 6.0 && here < 1e-3) mark(place, 0.5, must_);
  }
  static void mark(const dvec2& place, double radius, std::vector<bool>& marked) {
    for (int y = int(place.y - radius - 1.0); y <= int(place.y + radius + 1.0); ++y)
      for (int x = int(place.x - radius - 1.0); x <= int(place.x + radius + 1.0); ++x)
        if (x >= 0 && y >= 0 && x < kWidth && y < kHeight && glm::distance(dvec2(x + 0.5, y + 0.5), place) <= radius)
          marked[std::size_t(y * kWidth + x)] = true;
  }

  const raytrace::Tracer& tracer_;
  const core::View& view_;
  core::ImageRays rays_;
  raytrace::RayFilter filter_;
  std::vector<bool> may_, must_;
};

class Edges : public DrawnGrid, public testing::WithParamInterface<DrawingMode> {
 protected:
  EngineConfig configured(EdgeChoice which, engine::Renderer renderer = Renderer::kGl) {
    EngineConfig c = config(engine::CullerChoice::kCpu, kWidth, kHeight);
    c.drawing.renderer = renderer;
    if (renderer == Renderer::kRays) c.context.application = nullptr;
    c.drawing.looks.edges = {which, kLineWidth, {1.0f, 0.0f, 1.0f}};
    return c;
  }
  core::Expected<image::Image> image(Engine& engine, const core::View& view) {
    if (!draw_complete(engine, view)) return core::fail("not drawn");
    return engine.read_colour();
  }
  /// How much of a pixel a line covers, as its green channel tells.
  static std::vector<double> covers(const image::Image& plain, const image::Image& lined) {
    std::vector<double> found;
    for (std::size_t i = 1; i < plain.pixels.size(); i += 3)
      found.push_back(1.0 - double(lined.pixels[i]) / std::max(1, int(plain.pixels[i])));
    return found;
  }
};

/// Pixels that lines must cover, those of them that they do not, and others that they cover without need.
struct Counts {
  int must = 0, missed = 0, invented = 0;

  void add(const Twin& twin, const std::vector<double>& covers) {
    for (std::size_t i = 0; i < covers.size(); ++i) {
      must += twin.must(i);
      missed += twin.must(i) && covers[i] < 0.4;
      invented += !twin.may(i) && covers[i] > 0.1;
    }
  }
};

class EdgesOf : public Edges {};

TEST_P(EdgesOf, AreWhereRaysSeeThem) {
  const bool rays = std::string(GetParam().name) == "rays";
  Counts counts;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    core::Scene scene;
    furnish(scene, seed);
    ASSERT_TRUE(scene.commit());
    const core::Snapshot snapshot(scene);
    const auto tracer = raytrace::Tracer::create(snapshot);
    EngineConfig plain = configured(EdgeChoice::kOff), lined = configured(EdgeChoice::kFeature);
    GetParam().set(plain), GetParam().set(lined);
    if (rays) plain.context.application = lined.context.application = nullptr;
    auto without = Engine::create(scene, plain), with = Engine::create(scene, lined);
    ASSERT_TRUE(tracer && without && with);
    core::View cut = at(0.9);
    cut.sections = {{{0.0, 0.6, -0.8}, 0.4}};
    const core::View views[] = {at(0.3 + seed), parallel(1.1 + seed), cut};
    for (const core::View& view : views) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", view " << &view - views);
      const auto before = image(*without, view), after = image(*with, view);
      ASSERT_TRUE(before && after);
      counts.add(Twin(snapshot, *tracer, view), covers(*before, *after));
    }
  }
  // Where surfaces are thinner than the pixels that tell how they lean, or hardly seen.
  EXPECT_LT(counts.missed, 0.005 * counts.must);
  EXPECT_LT(counts.invented, 0.003 * counts.must);
  EXPECT_GT(counts.must, 15'000);
}

TEST_F(Edges, ChangeColourAlone) {
  core::Scene scene;
  furnish(scene, 5);
  ASSERT_TRUE(scene.commit());
  EngineConfig off = configured(EdgeChoice::kOff), on = configured(EdgeChoice::kFeature);
  off.drawing.ids = on.drawing.ids = true;
  auto plain = Engine::create(scene, off), engine = Engine::create(scene, on);
  ASSERT_TRUE(plain && engine);
  const core::View view = at(1.0);
  const auto before = image(*plain, view), lined = image(*engine, view);
  ASSERT_TRUE(before && lined);
  EXPECT_EQ(plain->read_ids()->ids, engine->read_ids()->ids);
  EXPECT_EQ(plain->read_depth(view)->metres, engine->read_depth(view)->metres);
  const auto coloured = [&](const image::Image& after) {
    const std::vector<double> found = covers(*before, after);
    return std::count_if(found.begin(), found.end(), [](double cover) { return cover > 0.1; });
  };
  const auto of_features = coloured(*lined);
  EXPECT_GT(of_features, 500);
  on.drawing.looks.edges.which = EdgeChoice::kAll;
  ASSERT_TRUE(engine->configure(on));
  EXPECT_GT(coloured(*image(*engine, view)), of_features + 50);
  on.drawing.looks.edges.which = EdgeChoice::kFeature;
  on.drawing.looks.edges.width = 6.0f;
  ASSERT_TRUE(engine->configure(on));
  EXPECT_GT(coloured(*image(*engine, view)), 2 * of_features);
  on.drawing.looks.edges.width = 0.1f;
  const auto refused = engine->configure(on);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("edge_width"), std::string::npos) << refused.error().message;
  ASSERT_TRUE(engine->configure(off));
  EXPECT_EQ(image(*engine, view)->pixels, before->pixels);
}

/// Meshes come and go, and others take their places in memory.
TEST_F(Edges, FollowEdits) {
  core::Scene scene;
  furnish(scene, 6);
  ASSERT_TRUE(scene.commit());
  auto engine = Engine::create(scene, configured(EdgeChoice::kFeature));
  ASSERT_TRUE(engine);
  const core::View view = at(2.0);
  std::vector<core::ItemId> added;
  for (int turn = 0; turn < 8; ++turn) {
    SCOPED_TRACE(turn);
    for (const core::ItemId item : added) {
      const core::MeshId mesh = scene.mesh_of(item);
      scene.remove_item(item);
      scene.remove_mesh(mesh);
    }
    added.clear();
    for (int i = 0; i < 3; ++i) {
      const core::Mesh mesh = gpuprims::tessellate(core::Box{1.0f + float(turn % 3), 2.0f, 1.0f + float(i)}, {});
      added.push_back(scene.add_mesh_instance(scene.root(), scene.add_mesh(mesh).value(),
                                              core::translation({2.0 * i - 2.0, 5.0, 0.5 * turn})));
    }
    ASSERT_TRUE(engine->commit());
    auto fresh = Engine::create(scene, configured(EdgeChoice::kFeature));
    ASSERT_TRUE(fresh);
    const auto found = image(*engine, view), wanted = image(*fresh, view);
    ASSERT_TRUE(found && wanted);
    int most = 0;  // places are rounded from other origins
    for (std::size_t i = 0; i < found->pixels.size(); ++i)
      most = std::max(most, std::abs(int(found->pixels[i]) - int(wanted->pixels[i])));
    EXPECT_LE(most, 2);
  }
}

TEST_F(Edges, CostNothingWhereNobodyAsks) {
  core::Scene scene;
  furnish(scene, 7);
  ASSERT_TRUE(scene.commit());
  auto engine = Engine::create(scene, configured(EdgeChoice::kOff));
  ASSERT_TRUE(engine && image(*engine, at(1.0)));
  const std::size_t bytes = engine->memory().gpu;
  const auto& entries = engine->plan().entries;
  const auto entry =
      std::find_if(entries.begin(), entries.end(), [](const auto& one) { return one.feature == "edges"; });
  ASSERT_NE(entry, entries.end());
  EXPECT_FALSE(entry->used);
  ASSERT_TRUE(engine->configure(configured(EdgeChoice::kFeature)));
  ASSERT_TRUE(image(*engine, at(1.0)));
  EXPECT_GE(engine->memory().gpu, bytes + kWidth * kHeight);  // lines are put together in an image of their own
}

INSTANTIATE_TEST_SUITE_P(
    Modes, EdgesOf,
    testing::ValuesIn(drawing_modes({{"rays", [](EngineConfig& c) { c.drawing.renderer = Renderer::kRays; }},
                                     {"rays_samples",
                                      [](EngineConfig& c) {
                                        c.drawing.renderer = Renderer::kRays;
                                        c.context.application = nullptr;
                                        c.drawing.samples = 4;
                                      }}})),
    [](const auto& mode) { return tests::name_of(mode); });

}  // namespace
}  // namespace sightline::tests::edges_test
