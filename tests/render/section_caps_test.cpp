// Section planes cut closed meshes open to filled faces: every pixel of random stacks of boxes, as meshes and as
// primitives, against the spans of its ray inside them.
#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "sightline/engine/drawing.h"
#include "sightline/tests/render/pixel_reference.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec3;
using core::dvec4;
using core::View;

constexpr int kWidth = 96, kHeight = 72;
constexpr double kAspect = double(kWidth) / kHeight, kNear = 0.1;

struct Solid {
  core::Box box;
  Affine placed;
};

/// What a pixel shows: how deep, and every item that may be the one (solids overlap).
struct Expected {
  double depth = std::numeric_limits<double>::infinity();
  bool cut = false;
  std::vector<core::ItemId> items;
};

Expected expect(const std::vector<Solid>& solids, const View& view, int x, int y) {
  const tests::PixelRay ray = tests::pixel_ray(view, kWidth, kHeight, x, y);
  const dvec3 &origin = ray.origin, &direction = ray.direction;
  const std::vector<double> cuts = tests::section_entries(view, origin, direction);
  Expected expected;
  const auto offer = [&](double t, bool cut, core::ItemId item) {
    if (!(t >= ray.t_near) || t > expected.depth + 1e-9) return;
    if (t < expected.depth - 1e-9) expected = {t, cut, {}};
    expected.items.push_back(item);
  };
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const dmat3 inverse = glm::inverse(solids[i].placed.linear);
    const gpuprims::Hits hits =
        gpuprims::intersect(solids[i].box, {inverse * (origin - solids[i].placed.origin), inverse * direction});
    if (hits.count != 2) continue;
    for (int k = 0; k < 2; ++k)
      if (tests::sections_keep(view, origin + hits.hit[k].t * direction)) offer(hits.hit[k].t, false, core::ItemId(i));
    for (const double t : cuts)
      if (t > hits.hit[0].t && t < hits.hit[1].t) offer(t, true, core::ItemId(i));
  }
  return expected;
}

core::Mesh mesh_of(const core::Box& box, bool inverted) {
  core::Mesh mesh = gpuprims::tessellate(box);
  if (inverted)
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) std::swap(mesh.indices[i], mesh.indices[i + 1]);
  return mesh;
}

class SectionCaps : public tests::GlTest {
 protected:
  /// Renders the scene; compares every pixel but for a share of them, at edges. Returns how many showed a cut face.
  int check(core::Scene& scene, const std::vector<Solid>& solids, const View& view, double mismatches = 0.025) {
    engine::EngineConfig config;
    config.draw = config.ids = true;
    config.width = kWidth;
    config.height = kHeight;
    config.context = &*context;
    auto engine = engine::Engine::create(scene, config);
    EXPECT_TRUE(engine) << engine.error().message;
    if (!engine || !engine->frame(view)) return 0;
    engine->finish();
    const render::DepthImage depth = engine->drawing()->target().read_depth(view);
    const render::IdImage ids = engine->drawing()->target().read_ids();
    EXPECT_TRUE(engine->drawing()->take_gl_errors().empty());
    int wrong = 0, cut = 0, wrong_cut = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const std::size_t pixel = std::size_t(y * kWidth + x);
        const Expected e = expect(solids, view, x, y);
        const bool same_depth = std::isfinite(e.depth)
                                    ? std::abs(double(depth.metres[pixel]) - e.depth) <= 1e-4 * e.depth
                                    : std::isinf(depth.metres[pixel]);
        const bool same_item =
            e.items.empty() ? ids.ids[pixel] == 0 : std::count(e.items.begin(), e.items.end(), ids.ids[pixel] - 1) > 0;
        wrong += !same_depth || !same_item;
        cut += e.cut;
        wrong_cut += e.cut && (!same_depth || !same_item);
      }
    }
    EXPECT_LE(wrong, mismatches * kWidth * kHeight) << "of " << kWidth * kHeight << " pixels";
    EXPECT_LE(wrong_cut, 1 + 2 * mismatches * cut) << "of " << cut << " on cut faces";
    return cut;
  }
};

/// Boxes about the origin, some nested, some overlapping, turned, mirrored and sheared; every fourth is a primitive,
/// every third mesh inside out.
void add_random_solids(core::Scene& scene, std::vector<Solid>& solids, std::mt19937& random, int count) {
  const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
  for (int i = 0; i < count; ++i) {
    Solid solid;
    solid.box = {float(uniform(0.3, 2.5)), float(uniform(0.3, 2.5)), float(uniform(0.3, 2.5))};
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) solid.placed.linear[c][r] = (c == r ? 1.0 : 0.0) + uniform(-0.4, 0.4);
    if (i % 2 == 1) solid.placed.linear[0] = -solid.placed.linear[0];
    solid.placed.origin = dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    const core::NodeId node = scene.add_node(scene.root(), "solid", solid.placed);
    if (i % 4 == 3) {
      scene.add_primitive(node, solid.box);
    } else {
      scene.add_mesh_instance(node, scene.add_mesh(mesh_of(solid.box, i % 3 == 2)).value());
    }
    solids.push_back(solid);
  }
}

View random_cut(std::mt19937& random, int sections) {
  const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
  const auto direction = [&] { return glm::normalize(dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1) + 1e-3)); };
  View view = *View::perspective({6.0 * direction(), {0, 0, 0}, {0, 0, 1}}, 0.6, kAspect, kNear);
  for (int i = 0; i < sections; ++i) view.sections.push_back({direction(), uniform(-0.5, 0.5)});
  view.section_mode = random() % 2 ? core::SectionMode::kUnion : core::SectionMode::kIntersection;
  return view;
}

TEST_F(SectionCaps, FillStacksOfMeshesAndPrimitives) {
  int cut = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    core::Scene scene;
    std::vector<Solid> solids;
    add_random_solids(scene, solids, random, 1 + int(seed % 9));
    cut += check(scene, solids, random_cut(random, 1 + int(seed % 3)));
  }
  EXPECT_GT(cut, 15000) << "hardly anything was cut";
}

TEST_F(SectionCaps, NameTheInnerSolidOfANestedPairByItsOwnCrossings) {
  // The point cut is in the outer box alone although the inner one's far wall comes first behind it.
  core::Scene scene;
  std::vector<Solid> solids{{{4, 4, 4}, {}}, {{1, 1, 1}, {dmat3(1.0), {0, 1.2, 0}}}};
  for (const Solid& solid : solids) {
    const core::NodeId node = scene.add_node(scene.root(), "box", solid.placed);
    scene.add_mesh_instance(node, scene.add_mesh(mesh_of(solid.box, false)).value());
  }
  View view = *View::perspective({{0, -8, 0.5}, {0, 0, 0}, {0, 0, 1}}, 0.7, kAspect, kNear);
  view.sections = {{{0, 1, 0}, 0.0}};
  EXPECT_GT(check(scene, solids, view), 1000);
  view.sections = {{{0, 1, 0}, -1.2}};  // through both
  EXPECT_GT(check(scene, solids, view), 1000);
}

TEST_F(SectionCaps, LeaveOpenMeshesOpen) {
  core::Scene scene;
  core::Mesh sheet = mesh_of({2, 2, 2}, false);
  sheet.indices.resize(sheet.indices.size() - 6);
  const core::NodeId node = scene.add_node(scene.root(), "box");
  scene.add_mesh_instance(node, scene.add_mesh(sheet).value());
  View view = *View::perspective({{0, -8, 0.1}, {0, 0, 0}, {0, 0, 1}}, 0.5, kAspect, kNear);
  view.sections = {{{0, 1, 0}, 0.0}};
  engine::EngineConfig config;
  config.draw = true;
  config.width = kWidth;
  config.height = kHeight;
  config.context = &*context;
  auto engine = engine::Engine::create(scene, config);
  ASSERT_TRUE(engine && engine->frame(view));
  engine->finish();
  const render::DepthImage depth = engine->drawing()->target().read_depth(view);
  EXPECT_NEAR(depth.metres[kHeight / 2 * kWidth + kWidth / 2], 9.0, 2e-3) << "the far wall";
}

TEST(Enclosure, TellsSolidsFromSheets) {
  core::Mesh mesh = mesh_of({1, 2, 3}, false);
  EXPECT_EQ(core::enclosure(mesh), core::Enclosure::kInside);
  EXPECT_EQ(core::enclosure(mesh_of({1, 2, 3}, true)), core::Enclosure::kOutside);
  std::swap(mesh.indices[0], mesh.indices[1]);
  EXPECT_EQ(core::enclosure(mesh), core::Enclosure::kNothing) << "one triangle turned";
  mesh = mesh_of({1, 2, 3}, false);
  mesh.indices.resize(mesh.indices.size() - 3);
  EXPECT_EQ(core::enclosure(mesh), core::Enclosure::kNothing) << "one triangle missing";
  EXPECT_EQ(core::enclosure({}), core::Enclosure::kNothing);
}

}  // namespace
}  // namespace sightline
