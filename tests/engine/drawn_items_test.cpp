// What the engine leaves out of drawing, and that no image shows it.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/tests/culling/scenes.h"
#include "sightline/tests/support/application_threads.h"
#include "sightline/tests/support/effort.h"
#include "sightline/tests/support/gl_test.h"
#include "sightline/tests/support/simulated_gpu.h"

namespace sightline::engine::drawn_items_test {
namespace {

using core::dvec3;
using core::View;
using tests::chance;
using tests::magnitude;
using tests::point;
using tests::Random;
using tests::uniform;
using tests::whole;

/// Items of all kinds, from far below a pixel to larger than the image, some of them transparent.
void fill(Random& random, core::Scene& scene, const dvec3& middle) {
  const core::MaterialId glass = scene.add_material({.name = "glass", .alpha = 0.5f});
  core::Mesh tetrahedron;
  tetrahedron.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  tetrahedron.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  const core::MeshId mesh = scene.add_mesh(tetrahedron).value();
  for (int i = 0; i < 1500; ++i) {
    const double size = magnitude(random, 2e-3, 0.6);
    core::Affine place = core::translation(middle + point(random, 10.0));
    place.linear = core::dmat3(size);
    const core::MaterialId material = chance(random, 0.1) ? glass : core::MaterialId{};
    const auto add = [&](const core::Primitive& p) { scene.add_primitive(scene.root(), p, place, material); };
    if (chance(random, 0.5)) place.linear = size * tests::random_rotation(random);
    switch (whole(random, 0, 11)) {
      case 0:
        add(core::Box{1, 2, 3});
        break;
      case 1:
        add(core::Sphere{2});
        break;
      case 2:
        add(core::CircularTorus{2, 0.5f, 2});
        break;
      case 3:
        add(core::Snout{1, 0.5f, 2, 0.3f, 0, 0, 0, 0, 0});
        break;
      case 4:
        scene.add_mesh_instance(scene.root(), mesh, place, material);
        break;
      case 5:
        add(core::Line{-1, 1});
        break;
      case 6:
        add(core::Pyramid{1, 2, 2, 1, 0.5f, 0, 2});
        break;
      case 7:
        add(core::RectangularTorus{1, 2, 1, 2});
        break;
      case 8:
        add(core::EllipticalDish{2, 1});
        break;
      case 9:
        add(core::SphericalDish{2, 1});
        break;
      default:  // a long pipe, much thinner than a pixel more often than not
        add(core::Cylinder{float(magnitude(random, 1e-3, 0.3)), 12.0f});
    }
  }
}

/// Runs of pipes and elbows that cover each other's ends, some of them so wide that the eye is in them now and then.
void add_pipes(Random& random, core::Scene& scene, const dvec3& middle) {
  for (int run = 0; run < 8; ++run) {
    const float radius = float(magnitude(random, 0.02, 2.0)), length = float(uniform(random, 1.0, 5.0));
    core::Affine end{tests::random_rotation(random),
                     middle + point(random, 8.0)};  // the next item begins there, along z
    for (int i = 0; i < 12; ++i) {
      if (i % 2 == 0) {
        scene.add_primitive(scene.root(), core::Cylinder{radius, length},
                            end * core::translation({0, 0, 0.5 * length}));
        end = end * core::translation({0, 0, length});
        continue;
      }
      const float bend = 3.0f * radius, angle = float(uniform(random, 0.3, 1.6));
      // The elbow's sweep begins on its x axis, towards its y axis.
      const core::Affine elbow = end * core::Affine{{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, {-bend, 0, 0}};
      scene.add_primitive(scene.root(), core::CircularTorus{bend, radius, angle}, elbow);
      const double c = std::cos(angle), s = std::sin(angle);
      end = elbow * core::Affine{{{c, s, 0}, {0, 0, -1}, {-s, c, 0}}, {bend * c, bend * s, 0}};
    }
  }
}

View view_of(Random& random, const dvec3& middle, double aspect) {
  core::Pose pose{middle + point(random, 18.0), middle + point(random, 6.0), {0, 0, 1}};
  View view = chance(random, 0.3)
                  ? *View::orthographic(pose, uniform(random, 2.0, 30.0), aspect, -40.0, 60.0)
                  : *View::perspective(pose, uniform(random, 0.2, 1.6), aspect, magnitude(random, 1e-3, 0.5),
                                       chance(random, 0.5) ? core::kInfiniteFar : 200.0);
  if (chance(random, 0.2)) {
    const dvec3 normal = glm::normalize(point(random, 1.0));
    view.sections = {{normal, -glm::dot(normal, middle)}};
  }
  return view;
}

/// On the CPU, or on the GPU in one of its variants.
struct Path {
  CullerChoice culler = CullerChoice::kCpu;
  std::optional<culling::GpuVariant> gpu = {};
};
constexpr Path kPaths[] = {
    {}, {CullerChoice::kGpu, {culling::GpuVariant::kGeometry}}, {CullerChoice::kGpu, {culling::GpuVariant::kCompute}}};
std::string path_name(const testing::TestParamInfo<Path>& path) {
  return path.param.gpu ? std::string(name_of(*path.param.gpu)) : "cpu";
}

class DrawnItems : public tests::GlTest {
 protected:
  EngineConfig config(const Path& path, int width, int height) {
    EngineConfig made;
    made.draw = made.drawing.ids = true;
    made.culling.culler = path.culler;
    made.culling.gpu_variant = path.gpu;
    made.width = width, made.height = height;
    made.context.application = &*context;
    return made;
  }
};

/// Draws a view. The GPU's counts come late.
core::Expected<FrameReport> drawn(Engine& engine, const View& view) {
  auto report = engine.frame(view);
  if (!report || report->culler != CullerChoice::kGpu) return report;
  engine.finish();
  const auto late = engine.take_late_report();
  if (!late || late->frame != report->frame) return core::fail("no late report");
  report->visible = late->visible;
  report->items_drawn = late->items_drawn;
  return report;
}

/// What loses items is the CPU's: a GPU that must cull is an error, a hybrid does without it and says so.
TEST_F(DrawnItems, LossesNeedACullerOnTheCpu) {
  core::Scene scene;
  for (int i = 0; i < int(kSmallHybridScene); ++i)
    scene.add_primitive(scene.root(), core::Box{0.4f, 0.4f, 0.4f}, core::translation({i % 100, i / 100, 0}));
  for (const bool budget : {false, true}) {
    SCOPED_TRACE(budget ? "budget" : "contribution");
    EngineConfig with = config({CullerChoice::kGpu}, 32, 32);
    if (budget)
      with.losses.budget_ms = 20.0;
    else
      with.losses.min_projected_area = 20.0f;
    const auto refused = Engine::create(scene, with);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("need a culler on the CPU"), std::string::npos) << refused.error().message;
    with.culling.culler = CullerChoice::kHybrid;
    auto engine = Engine::create(scene, with);
    ASSERT_TRUE(engine);
    EXPECT_EQ(name_of(engine->plan().culler), "cpu");
    EXPECT_FALSE(engine->set_culler(CullerChoice::kGpu));
    EXPECT_EQ(name_of(engine->plan().culler), "cpu");
    EXPECT_TRUE(engine->set_culler(CullerChoice::kLinear));
    EXPECT_TRUE(engine->set_culler(CullerChoice::kHybrid));
    EXPECT_EQ(engine->controller(), nullptr);
    const std::string name = budget ? "frame budget" : "contribution threshold";
    int found = 0;
    for (const PlanEntry& entry : engine->plan().entries) {
      found += entry.feature == name && entry.used;
      found += entry.feature == "hybrid controller" && !entry.used &&
               entry.why == "a " + name + " needs a culler on the CPU";
    }
    EXPECT_EQ(found, 2);
    with.draw = false;
    with.culling.culler = CullerChoice::kGpu;
    EXPECT_TRUE(Engine::create(scene, with)) << "nothing is drawn, so nothing is lost";
  }
}

class SampleTestDrawnItems : public DrawnItems, public testing::WithParamInterface<Path> {};

TEST_P(SampleTestDrawnItems, LosesNoPixel) {
  std::int64_t visible = 0, shown = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const dvec3 middle = chance(random, 0.5) ? dvec3(0.0) : dvec3(4e5, 6e6, 100.0);
    core::Scene scene;
    fill(random, scene, middle);
    const int width = whole(random, 1, 90), height = whole(random, 1, 70);
    EngineConfig with = config(GetParam(), width, height);
    if (seed % 4 == 0) with.drawing.samples = 4;
    EngineConfig without = with;
    without.culling.sample_test = false;
    auto tested = Engine::create(scene, with), all = Engine::create(scene, without);
    ASSERT_TRUE(tested && all);
    for (int i = 0; i < 40; ++i) {
      SCOPED_TRACE(testing::Message() << "view " << i);
      const View view = view_of(random, middle, double(width) / height);
      const auto few = drawn(*tested, view), many = drawn(*all, view);
      ASSERT_TRUE(few && many);
      ASSERT_EQ(many->visible, few->visible);
      ASSERT_EQ(many->items_drawn, many->visible);
      ASSERT_LE(few->items_drawn, few->visible);
      ASSERT_EQ(tested->read_ids()->ids, all->read_ids()->ids);
      ASSERT_EQ(tested->read_colour()->pixels, all->read_colour()->pixels);
      visible += few->visible;
      shown += few->items_drawn;
    }
  }
  EXPECT_LT(shown, visible * 8 / 10);
}

INSTANTIATE_TEST_SUITE_P(Paths, SampleTestDrawnItems, testing::ValuesIn(kPaths), path_name);

/// Whoever prepares the frames: one thread, several, or the application's.
TEST_F(DrawnItems, AreTheSameForAnyThreads) {
  Random random(3);
  core::Scene scene;
  for (int i = 0; i < 6; ++i) fill(random, scene, point(random, 10.0));
  tests::ApplicationThreads runner;
  for (const OcclusionChoice occlusion : {OcclusionChoice::kOff, OcclusionChoice::kOn}) {
    std::vector<Engine> engines;
    for (const int threads : {1, 2, 5, 0}) {
      EngineConfig with = config({}, 90, 70);
      with.culling.occlusion = occlusion;
      with.threads = threads;
      if (threads == 0) with.runner = &runner;
      auto engine = Engine::create(scene, with);
      ASSERT_TRUE(engine);
      engines.push_back(std::move(*engine));
    }
    for (int i = 0; i < 20; ++i) {
      SCOPED_TRACE(testing::Message() << name_of(occlusion) << ", view " << i);
      const View view = view_of(random, dvec3(0.0), 90.0 / 70.0);
      std::optional<std::int64_t> drawn;
      for (Engine& engine : engines) {
        const auto report = engine.frame(view);
        ASSERT_TRUE(report);
        EXPECT_EQ(report->items_drawn, drawn.value_or(report->items_drawn));
        drawn = report->items_drawn;
        ASSERT_EQ(engine.read_ids()->ids, engines[0].read_ids()->ids);
        ASSERT_EQ(engine.read_colour()->pixels, engines[0].read_colour()->pixels);
      }
    }
  }
  EXPECT_GT(runner.calls, 0);
}

/// A wall with a gap of a pixel or less, doors, boxes inside one another: much is hidden, little of it wholly.
void add_walls(Random& random, core::Scene& scene, const dvec3& middle) {
  for (int i = 0; i < 12; ++i) {
    core::Affine place = core::translation(middle + point(random, 9.0));
    const float thin = float(magnitude(random, 1e-3, 0.3)), wide = float(uniform(random, 2.0, 12.0));
    const int axis = whole(random, 0, 2);
    const core::Box wall{axis == 0 ? thin : wide, axis == 1 ? thin : wide, axis == 2 ? thin : wide};
    scene.add_primitive(scene.root(), wall, place);
    place.origin[(axis + 1) % 3] += wide + magnitude(random, 1e-3, 0.1);  // beside it, a gap apart
    scene.add_primitive(scene.root(), wall, place);
  }
}

/// Pixels whose item differs though the depths do not: two surfaces at one distance, of which either may win.
struct Difference {
  int pixels = 0, ties = 0;
};
Difference compare(Engine& a, Engine& b, const View& view) {
  const image::IdImage ids = *a.read_ids(), other_ids = *b.read_ids();
  Difference found;
  if (ids.ids == other_ids.ids) return found;
  const image::DepthImage depth = *a.read_depth(view), other_depth = *b.read_depth(view);
  for (std::size_t i = 0; i < ids.ids.size(); ++i)
    if (ids.ids[i] != other_ids.ids[i]) ++(depth.metres[i] == other_depth.metres[i] ? found.ties : found.pixels);
  return found;
}

/// Items below the threshold are absent, and no others; what is kept leaves later than it comes.
TEST_F(DrawnItems, ContributionLeavesOutWhatIsSmall) {
  core::Scene scene;
  std::vector<core::ItemId> plates;  // which show half as much from any direction as from the front
  for (int i = 0; i < 40; ++i)       // edges of 1, 2, … cm
    plates.push_back(scene.add_primitive(scene.root(), core::Box{0.01f * float(i + 1), 1e-4f, 0.01f * float(i + 1)},
                                         core::translation({0.6 * (i % 8) - 2.0, 0.0, 0.5 * int(i / 8) - 1.0})));
  const core::ItemId line = scene.add_primitive(scene.root(), core::Line{-1, 1}, core::translation({0, 1, 0}));
  EngineConfig with = config(kPaths[0], 400, 300);
  with.losses.min_projected_area = 100.0f;
  auto engine = Engine::create(scene, with);
  ASSERT_TRUE(engine);
  const auto from = [](double distance) {
    return *View::perspective({{0, -distance, 0}, {0, 0, 0}, {0, 0, 1}}, 1.0, 4.0 / 3.0, 0.1);
  };
  const auto drawn = [&](double distance) {
    const auto report = engine->frame(from(distance));
    std::vector<bool> found(scene.item_slots());
    const image::IdImage ids = *engine->read_ids();
    for (const auto id : ids.ids)
      if (id != 0) found[id - 1] = true;
    EXPECT_EQ(report->visible - report->below_min_area, report->items_drawn);
    return found;
  };
  const double per_metre = 150.0 / std::tan(0.5) / 4.0;
  const auto near = drawn(4.0);
  EXPECT_TRUE(near[to_index(line)]);
  for (std::size_t i = 0; i < plates.size(); ++i) {
    const double edge = 0.01 * double(i + 1) * per_metre;
    const double aside = glm::length(scene.placement(plates[i]).origin - core::dvec3(0, -4, 0)) / 4.0;
    const double area = 0.5 * edge * edge * aside;  // the image is flat, and larger aside
    if (std::abs(area - 100.0) > 0.5) {
      EXPECT_EQ(bool(near[to_index(plates[i])]), area > 100.0) << i;
    }
  }
  const auto stayed = drawn(4.0 * 1.1);  // areas are 0.83 of what they were
  EXPECT_EQ(stayed, near);
  const auto gone = drawn(4.0 * 1.2);
  EXPECT_LT(std::count(gone.begin(), gone.end(), true), std::count(near.begin(), near.end(), true));
  EXPECT_EQ(drawn(4.0 * 1.1), gone) << "comes back at the threshold only";
  with.losses.min_projected_area = -1.0f;
  EXPECT_FALSE(Engine::create(scene, with));
  with.losses.min_projected_area = std::nanf("");
  EXPECT_FALSE(Engine::create(scene, with));
}

/// A budget too small for the image: the frames of a view that stays complete it, and then nothing is drawn; an edit,
/// another view or size begins anew. So it is with splats for what is not drawn yet.
class Budget : public DrawnItems,
               public ::testing::WithParamInterface<std::tuple<ContributionMode, int>> {};  // samples

TEST_P(Budget, IsMadeUpForAtRest) {
  Random random(5);
  core::Scene scene;
  fill(random, scene, dvec3(0.0));
  EngineConfig with = config(kPaths[0], 80, 60), without = with;
  with.losses.budget_ms = 1e-3;
  std::tie(with.losses.contribution_mode, with.drawing.samples) = GetParam();
  without.drawing.samples = with.drawing.samples;
  const bool splats = with.losses.contribution_mode != ContributionMode::kDrop;
  std::optional<tests::SimulatedGpu> gpu;
  if (splats) gpu.emplace(*context, tests::CardModel());  // software rasterisers draw coarser images instead
  auto hurried = Engine::create(scene, with), all = Engine::create(scene, without);
  ASSERT_TRUE(hurried && all);
  engine::EngineParts::set_traces_motion(*hurried, false);
  std::int64_t splats_drawn = 0;
  for (int i = 0; i < 12; ++i) {
    SCOPED_TRACE(testing::Message() << "view " << i);
    if (i == 4) {
      scene.set_visible(core::ItemId{3}, false);
      ASSERT_TRUE(hurried->commit() && all->commit());
    }
    if (i == 8) {
      ASSERT_TRUE(hurried->resize(61, 47) && all->resize(61, 47));
    }
    const View view = view_of(random, dvec3(0.0), 4.0 / 3.0);
    ASSERT_TRUE(all->frame(view));
    int frames = 1;
    auto report = hurried->frame(view);
    ASSERT_TRUE(report);
    if (report->visible > 500 && (i > 0 || splats)) {  // the first frame is not known to be late
      EXPECT_GT(report->pending, 0);
    }
    for (std::int64_t before = report->pending; report->pending > 0; before = report->pending, ++frames) {
      ASSERT_LT(frames, 1000);
      report = hurried->frame(view);
      ASSERT_TRUE(report);
      if (frames > 1) {
        ASSERT_LT(report->pending, before);
      }
      ASSERT_LE(report->splats, splats ? report->pending : 0);
      splats_drawn += report->splats;
    }
    EXPECT_EQ(compare(*hurried, *all, view).pixels, 0);
    const std::int64_t shown = report->items_drawn;
    report = hurried->frame(view);
    EXPECT_EQ(report->items_drawn, shown) << "nothing is drawn again";
    EXPECT_EQ(report->pending, 0);
    if (i % 4 == 1) {  // time enough for what is measured while the view moves: small items are pending all the same
      const View next = view_of(random, dvec3(0.0), 4.0 / 3.0), last = view_of(random, dvec3(0.0), 4.0 / 3.0);
      ASSERT_TRUE(hurried->frame(next));
      const auto moving = hurried->frame(last);
      ASSERT_TRUE(moving && all->frame(last));
      if (moving->pending == 0) {
        EXPECT_EQ(compare(*hurried, *all, last).pixels, 0);
      }
      continue;
    }
    if (i % 3 == 0) {  // an edit of what is seen, the view staying
      scene.set_visible(core::ItemId(i), false);
      ASSERT_TRUE(hurried->commit() && all->commit());
      ASSERT_TRUE(all->frame(view));
      do {
        report = hurried->frame(view);
      } while (report->pending > 0);
      EXPECT_EQ(compare(*hurried, *all, view).pixels, 0);
    }
  }
  EXPECT_EQ(splats_drawn > 0, splats);
  with.losses.budget_ms = -1.0;
  EXPECT_FALSE(Engine::create(scene, with));
}

/// Frames of a large image have a large overhead, which may exceed any budget. The number of frames must not follow
/// from that.
TEST_F(DrawnItems, ABudgetGoesOnInLargeImages) {
  constexpr int kSide = 110;
  core::Scene scene;
  for (int i = 0; i < kSide * kSide; ++i)
    scene.add_primitive(scene.root(), core::Box{0.4f, 0.4f, 0.4f}, core::translation({i % kSide, i / kSide, 0}));
  const View view = *View::fit({dvec3(-1.0), {kSide, kSide, 1.0}}, core::kOverviewDirection, 0.7, 1.0);
  for (const bool shaded : {false, true}) {
    EngineConfig with = config(kPaths[0], 2048, 2048);
    with.losses.budget_ms = 1e-3;
    if (shaded) with.drawing.looks.depth_shading = {0.5f, 0.5f};
    auto engine = Engine::create(scene, with);
    ASSERT_TRUE(engine);
    std::int64_t pending = 1;
    int frames = 0;
    for (; pending > 0; ++frames) pending = engine->frame(view)->pending;
    EXPECT_LT(frames, 60) << "64 items a frame would take 190";
  }
}

using ModeAndSamples = std::tuple<ContributionMode, int>;
std::string budget_name(const testing::TestParamInfo<ModeAndSamples>& info) {
  return std::string(name_of(std::get<0>(info.param))) + (std::get<1>(info.param) == 1 ? "" : "_multisampled");
}
INSTANTIATE_TEST_SUITE_P(DrawnItems, Budget,
                         ::testing::Combine(::testing::Values(ContributionMode::kDrop, ContributionMode::kPoints),
                                            ::testing::Values(1, 4)),
                         budget_name);

/// A view handed in twice is that view, whichever object names it.
TEST_F(DrawnItems, ABudgetIsMadeUpForWhereTheCullingViewIsACopy) {
  Random random(6);
  core::Scene scene;
  fill(random, scene, dvec3(0.0));
  EngineConfig with = config(kPaths[0], 80, 60);
  with.losses.budget_ms = 1e-3;
  with.drawing.culled_colour = core::vec3(0, 0, 1);
  auto engine = Engine::create(scene, with);
  ASSERT_TRUE(engine);
  const View view = view_of(random, dvec3(0.0), 4.0 / 3.0), copy = view;
  auto report = engine->frame({.view = view, .cull_view = &copy});
  for (int i = 0; i < 1000 && report && report->pending > 0; ++i)
    report = engine->frame({.view = view, .cull_view = &copy});
  ASSERT_TRUE(report);
  EXPECT_EQ(report->pending, 0);
}

/// A wall with cubes behind it and beside it, and one cube that is too small for the view that culls.
class CulledColour : public DrawnItems {
 protected:
  static constexpr double kSmall = 2e-3;
  void SetUp() override {
    DrawnItems::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    const auto add = [&](double size, double x, double y, double z) {
      const auto s = float(size);
      return scene.add_primitive(scene.root(), core::Box{s, s, s}, core::translation({x, y, z}));
    };
    wall = scene.add_primitive(scene.root(), core::Box{6, 0.2f, 6});
    for (int i = 0; i < 4; ++i) behind.push_back(add(0.5, i - 1.5, 3, i - 1.5));
    for (int i = 0; i < 4; ++i) beside.push_back(add(0.5, 5.0, 3, i - 1.5));
    // Between the lines of sight of two neighbouring pixels.
    small = add(kSmall, 4.0, 0.0, 0.5 * 10.0 * 2.0 * std::tan(0.5) / 100.0);
  }
  /// Names of items that an image shows in the colour of hidden ones, and of those in another.
  std::array<std::set<core::ItemId>, 2> items_by_colour(Engine& engine) {
    const image::Image colour = *engine.read_colour();
    const image::IdImage ids = *engine.read_ids();
    std::array<std::set<core::ItemId>, 2> found;
    for (std::size_t i = 0; i < ids.ids.size(); ++i)
      if (ids.ids[i] != 0)
        found[colour.pixels[3 * i] < colour.pixels[3 * i + 2] / 2].insert(core::ItemId{ids.ids[i] - 1});
    return found;
  }
  core::Scene scene;
  core::ItemId wall{0}, small = core::ItemId{0};
  std::vector<core::ItemId> behind, beside;
  const View front = *View::perspective({{0, -10, 0}, {0, 0, 0}, {0, 0, 1}}, 1.0, 1.5, 0.1);
  const View back = *View::perspective({{-4, 12, 8}, {0, 0, 0}, {0, 0, 1}}, 1.0, 1.5, 0.1);
  const View close = *View::perspective({{4, -1e-2, 0.06}, {4, 0, 0.055}, {0, 0, 1}}, 1.0, 1.5, 1e-3);
};

TEST_F(CulledColour, ShowsFromAsideWhatTheTestsLeaveOut) {
  const auto set = [](const std::vector<core::ItemId>& items) {
    return std::set<core::ItemId>(items.begin(), items.end());
  };
  for (const CullerChoice culler : {CullerChoice::kLinear, CullerChoice::kCpu, CullerChoice::kGpu})
    for (const OcclusionChoice occlusion : {OcclusionChoice::kOn, OcclusionChoice::kAutomatic, OcclusionChoice::kOff}) {
      SCOPED_TRACE(testing::Message() << name_of(culler) << ", occlusion " << name_of(occlusion));
      scene.set_visible(wall, true);
      EngineConfig with = config({culler}, 150, 100);
      with.culling.occlusion = occlusion;
      auto plain = Engine::create(scene, with);
      with.drawing.culled_colour = core::vec3(0, 0, 1);
      auto engine = Engine::create(scene, with);
      ASSERT_TRUE(plain && engine);
      const bool tested = occlusion != OcclusionChoice::kOff;
      std::set<core::ItemId> shown = set(beside);
      shown.insert(wall);
      if (!tested) shown.insert(behind.begin(), behind.end());
      for (int frame = 0; frame < 3; ++frame) {
        ASSERT_TRUE(engine->frame({.view = back, .cull_view = &front}) &&
                    plain->frame({.view = back, .cull_view = &front}));
        EXPECT_EQ(items_by_colour(*engine)[1], tested ? set(behind) : std::set<core::ItemId>());
        EXPECT_EQ(items_by_colour(*engine)[0], shown);
        EXPECT_EQ(compare(*engine, *plain, back).pixels, 0) << "the same items";
        EXPECT_TRUE(items_by_colour(*plain)[1].empty());
      }
      ASSERT_TRUE(engine->frame({.view = close, .cull_view = &front}));
      EXPECT_EQ(items_by_colour(*engine)[1].count(small), 1u) << "no sample lies on it";

      ASSERT_TRUE(engine->frame(back) && plain->frame(back));
      EXPECT_EQ(engine->read_colour()->pixels, plain->read_colour()->pixels) << "not frozen";
      ASSERT_TRUE(engine->frame({.view = back, .cull_view = &front}));
      EXPECT_EQ(items_by_colour(*engine)[1].size(), tested ? behind.size() : 0u) << "frozen again";
      scene.set_visible(wall, false);
      ASSERT_TRUE(engine->commit() && engine->frame({.view = back, .cull_view = &front}));
      EXPECT_TRUE(items_by_colour(*engine)[1].empty()) << "an edit has opened the view";
    }
}

TEST_F(CulledColour, WithABudgetAndSeveralSamples) {
  EngineConfig with = config(kPaths[0], 150, 100);
  with.drawing.culled_colour = core::vec3(0, 0, 1);
  with.losses.budget_ms = 1e-3;
  auto hurried = Engine::create(scene, with);
  ASSERT_TRUE(hurried);
  auto report = hurried->frame({.view = back, .cull_view = &front});
  for (int i = 0; i < 100 && report && report->pending > 0; ++i)
    report = hurried->frame({.view = back, .cull_view = &front});
  ASSERT_TRUE(report);
  EXPECT_EQ(report->pending, 0);
  EXPECT_EQ(items_by_colour(*hurried)[1].size(), behind.size());
  ASSERT_TRUE(hurried->frame(back));
  while (hurried->frame(back)->pending > 0) continue;
  EXPECT_TRUE(items_by_colour(*hurried)[1].empty());

  with.losses.budget_ms = 0.0;
  with.drawing.samples = 4;
  auto smooth = Engine::create(scene, with);
  ASSERT_TRUE(smooth && smooth->frame({.view = back, .cull_view = &front}));
  EXPECT_TRUE(items_by_colour(*smooth)[1].empty()) << "occlusion is tested with one sample only";
}

/// An elbow shows its inside where the eye is in the pipe before it, or where that pipe is not drawn: the end that it
/// covers is not drawn. So the elbow's centre line hides nothing then.
TEST_F(DrawnItems, ShowsTheInsideOfOpenPipes) {
  core::Scene scene;
  scene.add_primitive(scene.root(), core::Cylinder{1, 10}, core::translation({0, 0, 5}));
  scene.add_primitive(scene.root(), core::CircularTorus{3, 1, 1.5f},
                      {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, {-3, 0, 10}});  // towards -x
  const core::Box cube{0.15f, 0.15f, 0.15f};                               // behind the centre line, before the wall
  const core::ItemId inside = scene.add_primitive(scene.root(), cube, core::translation({-0.92, 0.0, 12.7}));
  EngineConfig with = config(kPaths[0], 120, 90), without = with;
  with.culling.occlusion = OcclusionChoice::kOn;
  without.culling.occlusion = OcclusionChoice::kOff;
  auto tested = Engine::create(scene, with), all = Engine::create(scene, without);
  ASSERT_TRUE(tested && all);
  const auto from = [](const dvec3& eye, const dvec3& target) {
    return *View::perspective({eye, target, {0, 1, 0.1}}, 0.15, 4.0 / 3.0, 0.1);
  };
  const View in_pipe = from({0, 0, 1}, {-0.92, 0, 12.7}), before = from({0.5, 0, -5}, {-0.92, 0, 12.7});
  const View at_elbow = from({-2, -20, 12}, {-2, 0, 12});
  struct {
    const View &view, &cull_view;
    bool open;
  } const cases[] = {
      {in_pipe, in_pipe, true}, {before, before, false}, {before, at_elbow, true}, {before, before, false}};
  for (const auto& [view, cull_view, open] : cases) {
    for (int frame = 0; frame < 3; ++frame) {
      const auto report = tested->frame({.view = view, .cull_view = &cull_view});
      ASSERT_TRUE(report && all->frame({.view = view, .cull_view = &cull_view}));
      const std::vector<std::uint32_t> expected = all->read_ids()->ids;
      EXPECT_EQ(tested->read_ids()->ids, expected);
      EXPECT_EQ(std::count(expected.begin(), expected.end(), to_index(inside) + 1) > 5, open);
      if (!open) {
        EXPECT_EQ(report->items_drawn, 1) << "the pipe hides all the rest";
      }
    }
  }
}

/// By path and seed: 250 views of each of ten scenes, or 90 views of two: later views find what edits have spoilt.
class OcclusionDrawnItems : public DrawnItems, public testing::WithParamInterface<std::tuple<Path, int>> {};

/// Teleports, small steps, edits between frames, orthographic views, sections, transparency, any image size, which
/// changes; new scene versions, and another context.
TEST_P(OcclusionDrawnItems, LosesNoPixel) {
  std::int64_t visible = 0, shown = 0, pixels = 0;
  int ties = 0;
  const int scenes = tests::long_run() ? 10 : 2, views = tests::long_run() ? 250 : 90;
  for (int scene_number = 0; scene_number < scenes; ++scene_number) {
    const auto& [path, first_seed] = GetParam();
    const std::uint64_t seed = std::uint64_t(10 * first_seed + scene_number);
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const dvec3 middle = chance(random, 0.5) ? dvec3(0.0) : dvec3(4e5, 6e6, 100.0);
    core::Scene scene;
    fill(random, scene, middle);
    add_walls(random, scene, middle);
    if (chance(random, 0.5)) add_pipes(random, scene, middle);
    int width = whole(random, 1, 90), height = whole(random, 1, 70);
    EngineConfig with = config(path, width, height), without = with;
    with.culling.occlusion = OcclusionChoice::kOn;
    without.culling.occlusion = OcclusionChoice::kOff;
    without.culling.sample_test = false;
    auto tested = Engine::create(scene, with), all = Engine::create(scene, without);
    ASSERT_TRUE(tested && all);
    View view = view_of(random, middle, double(width) / height);
    for (int i = 0; i < views; ++i) {
      SCOPED_TRACE(testing::Message() << "view " << i);
      if (chance(random, 0.3)) view = view_of(random, middle, double(width) / height);
      if (chance(random, 0.3)) {  // a door opens, or anything else
        const core::ItemId item = core::ItemId(whole(random, 0, 1500 + 23));
        core::Affine place = scene.placement(item);
        place.origin += point(random, 3.0);
        chance(random, 0.5) ? scene.set_placement(item, place) : scene.set_visible(item, chance(random, 0.5));
        ASSERT_TRUE(tested->commit() && all->commit());
      }
      if (chance(random, 0.02)) {
        width = whole(random, 1, 90), height = whole(random, 1, 70);
        ASSERT_TRUE(tested->resize(width, height) && all->resize(width, height));
        view = view_of(random, middle, double(width) / height);
      }
      if (chance(random, 0.004)) {
        ASSERT_TRUE(tested->rebuild() && all->rebuild());
      }
      if (chance(random, 0.002)) {
        tested->drop_context();
        ASSERT_TRUE(tested->use_context(*context));
      }
      const auto few = drawn(*tested, view), many = drawn(*all, view);
      ASSERT_TRUE(few && many);
      ASSERT_EQ(few->visible, many->visible);
      ASSERT_LE(few->items_drawn, few->visible);
      ASSERT_EQ(many->items_drawn, many->visible);
      const Difference difference = compare(*tested, *all, view);
      ASSERT_EQ(difference.pixels, 0);
      ties += difference.ties;
      pixels += width * height;
      visible += few->visible;
      shown += few->items_drawn;
    }
  }
  EXPECT_LT(shown, visible * 8 / 10);
  EXPECT_LT(ties, pixels / 1000);
  RecordProperty("ties", ties);
}

/// Seeds of 2,500 views each in a long run: 10,000, unless SIGHTLINE_DRAWN_VIEWS names another number.
int seeds() {
  const char* views = std::getenv("SIGHTLINE_DRAWN_VIEWS");
  return views ? std::max(1, std::atoi(views) / 2500) : 4;
}

std::string path_and_seed(const testing::TestParamInfo<std::tuple<Path, int>>& test) {
  return path_name({std::get<0>(test.param), 0}) + "_" + std::to_string(std::get<1>(test.param));
}
INSTANTIATE_TEST_SUITE_P(Cpu, OcclusionDrawnItems,
                         testing::Combine(testing::Values(kPaths[0]), testing::Range(1, 1 + seeds())), path_and_seed);
INSTANTIATE_TEST_SUITE_P(Gpu, OcclusionDrawnItems,
                         testing::Combine(testing::Values(kPaths[1], kPaths[2]), testing::Range(1, 3)), path_and_seed);

}  // namespace
}  // namespace sightline::engine::drawn_items_test
