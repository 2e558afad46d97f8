// Frames with levels of detail: images lie within the allowed error of those in full, whoever culls; edits and new
// scene versions get levels of their own, and whoever does not ask for them pays nothing.
#include <set>

#include <gtest/gtest.h>

#include "sightline/lod/stored_levels.h"
#include "sightline/render/image/image_metrics.h"
#include "sightline/render/internal/renderer.h"
#include "sightline/tests/engine/drawn_grid.h"
#include "sightline/tests/lod/mesh_samples.h"
#include "sightline/tests/support/effort.h"
#include "sightline/tests/support/gl_watch.h"

namespace sightline::tests::levels_test {
namespace {

/// Who culls: the CPU, or a GPU in some way.
struct How {
  engine::CullerChoice culler = engine::CullerChoice::kCpu;
  std::optional<culling::GpuVariant> variant;
};

class Levels : public DrawnGrid {
 protected:
  static constexpr int kWidth = 240, kHeight = 160;

  /// Tori among boxes.
  void fill(core::Scene& scene) {
    const auto torus = scene.add_mesh(bumpy_torus(48, 0.05)).value();
    for (int i = 0; i < 9; ++i) {
      core::Affine at = core::translation({9.0 * (i % 3), 9.0 * (i / 3), 0.0});
      if (i % 2) at.linear = core::dmat3(1.5, 0, 0, 0, 0.5, 0.2, 0, 0, -1);
      items.push_back(scene.add_mesh_instance(scene.root(), torus, at));
    }
    scene.add_primitive(scene.root(), core::Box{30, 30, 0.1f}, core::translation({9, 9, -3}));
    ASSERT_TRUE(scene.commit());
  }
  static core::View look(double distance, double turn) {
    const core::dvec3 centre(9.0, 9.0, 0.0);
    return *core::View::perspective({centre + distance * core::dvec3(std::cos(turn), std::sin(turn), 0.6), centre}, 0.8,
                                    double(kWidth) / kHeight, 0.1);
  }
  engine::EngineConfig config_of(const How& how, double error) {
    engine::EngineConfig c = config(how.culler, kWidth, kHeight);
    c.culling.gpu_variant = how.variant;
    c.drawing.ids = true;
    c.losses.lod_error = error;
    return c;
  }
  engine::Engine create(core::Scene& scene, double error, const How& how = {}) {
    return create(scene, config_of(how, error));
  }
  static engine::Engine create(core::Scene& scene, const engine::EngineConfig& c) {
    auto made = engine::Engine::create(scene, c);
    EXPECT_TRUE(made) << made.error().message;
    EXPECT_TRUE(made->finish_levels());
    return std::move(*made);
  }
  static image::IdImage ids_of(engine::Engine& engine, const core::View& view) {
    EXPECT_TRUE(draw_complete(engine, view));
    return *engine.read_ids();
  }
  /// Pixels of `a` without the same id within `radius` pixels in `b`.
  static int apart(const image::IdImage& a, const image::IdImage& b, int radius) {
    int count = 0;
    for (int y = 0; y < a.height; ++y)
      for (int x = 0; x < a.width; ++x) {
        bool found = false;
        for (int v = std::max(0, y - radius); v <= std::min(a.height - 1, y + radius) && !found; ++v)
          for (int u = std::max(0, x - radius); u <= std::min(a.width - 1, x + radius) && !found; ++u)
            found = b.ids[std::size_t(v) * std::size_t(b.width) + std::size_t(u)] ==
                    a.ids[std::size_t(y) * std::size_t(a.width) + std::size_t(x)];
        count += !found;
      }
    return count;
  }

  std::vector<core::ItemId> items;
};

class LevelsByAny : public Levels, public testing::WithParamInterface<How> {};

INSTANTIATE_TEST_SUITE_P(Culler, LevelsByAny,
                         testing::Values(How{}, How{engine::CullerChoice::kGpu, culling::GpuVariant::kGeometry},
                                         How{engine::CullerChoice::kGpu, culling::GpuVariant::kCompute}),
                         [](const auto& how) {
                           return std::string(how.param.variant ? name_of(*how.param.variant) : "cpu");
                         });

TEST_P(LevelsByAny, ShowEachItemWithinTheAllowedPixels) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no coarser levels in this build";
  core::Scene scene;
  fill(scene);
  engine::Engine full = create(scene, 0.0);
  std::size_t different = 0;
  for (const double error : {0.5, 2.0, 6.0}) {
    engine::Engine coarse = create(scene, error, GetParam());
    for (const double distance : {12.0, 25.0, 60.0})
      for (const double turn : {0.3, 2.0, 4.1}) {
        const core::View view = look(distance, turn);
        const image::IdImage a = ids_of(full, view), b = ids_of(coarse, view);
        // A pixel shows what covers its centre. An item that shows through a gap which is narrower than the error may
        // be lost in it.
        const int radius = int(std::ceil(error)) + 1;
        EXPECT_LE(apart(a, b, radius), 2) << error << " px, " << distance << " m, " << turn;
        EXPECT_LE(apart(b, a, radius), 2) << error << " px, " << distance << " m, " << turn;
        different += *image::wrong_ids(a, b);
      }
  }
  EXPECT_GT(different, 100u) << "levels are drawn";
}

/// All items in the renderer's own way, each mesh as a whole.
class Whole {
 public:
  Whole(const gl::Context& context, const core::Scene& scene, int width, int height)
      : snapshot_(scene),
        gpu_(std::move(*gpuscene::GpuScene::create(context, snapshot_))),
        lists_(std::move(*gpuscene::DrawLists::create(context, gpu_))),
        renderer_(std::move(*render::Renderer::create(context, gpu_, {.ids = true}))),
        target_(std::move(*render::RenderTarget::create(context, width, height, {.ids = true}))) {
    core::VisibleSet all;
    all.ranges = {{0, core::Slot(snapshot_.size())}};
    EXPECT_TRUE(lists_.update(snapshot_, gpu_, all));
  }
  const render::RenderTarget& draw(const core::View& view) {
    EXPECT_TRUE(renderer_.draw(view, snapshot_, gpu_, lists_, target_));
    return target_;
  }

 private:
  core::Snapshot snapshot_;
  gpuscene::GpuScene gpu_;
  gpuscene::DrawLists lists_;
  render::Renderer renderer_;
  render::RenderTarget target_;
};

/// Without an allowed error large meshes are drawn by clusters, those in the view volume.
TEST_P(LevelsByAny, ClustersOfLargeMeshesShowEveryPixel) {
  core::Scene scene;
  const auto torus = scene.add_mesh(bumpy_torus(70, 0.1)).value();
  const auto hills = scene.add_mesh(joined(terrain(96, 1.2), bumpy_torus(20, 0.1), {5, 5, 0})).value();
  ASSERT_GT(scene.mesh(hills).indices.size(), 3 * lod::kLargeMesh);
  for (int i = 0; i < 3; ++i) {
    core::Affine at = core::translation({4.0 * i, 3.0, 1.0});
    if (i == 1) at.linear = core::dmat3(-1, 0, 0, 0, 0.7, 0.3, 0, 0, 1);
    scene.add_mesh_instance(scene.root(), i == 2 ? hills : torus, at);
  }
  ASSERT_TRUE(scene.commit());
  engine::EngineConfig c = config_of(GetParam(), 0.0);
  engine::Engine clusters = create(scene, c);
  c.culling.occlusion = engine::OcclusionChoice::kOn;
  engine::Engine tested = create(scene, c);
  Whole whole(*context, scene, kWidth, kHeight);
  std::mt19937_64 random(3);
  for (int i = 0; i < repeated(600, 30); ++i) {
    SCOPED_TRACE(i);
    const core::dvec3 eye(between(random, -3, 14), between(random, -3, 14), between(random, -2, 4));
    const core::dvec3 target(between(random, 0, 12), between(random, 0, 12), between(random, -1, 2));
    core::View view = *core::View::perspective({eye, target}, between(random, 0.2, 2.0), 1.5, 0.01);
    if (i % 5 == 0) view = *core::View::orthographic({eye, target}, between(random, 0.5, 12.0), 1.5, -5.0, 30.0);
    if (i % 3 == 0)
      view.sections.push_back({glm::normalize(target - eye), -glm::dot(glm::normalize(target - eye), target)});
    const image::IdImage wanted = whole.draw(view).read_ids();
    const std::vector<float> depth = whole.draw(view).read_depth(view).metres;
    for (engine::Engine* engine : {&clusters, &tested}) {
      for (const char* time : {"first", "again"}) {
        const image::IdImage shown = ids_of(*engine, view);
        ASSERT_EQ(engine->read_depth(view)->metres, depth) << time;
        // Beside section planes two items may have caps of the very same depth; the last one drawn shows.
        if (engine == &clusters || view.sections.empty()) {
          ASSERT_EQ(shown.ids, wanted.ids) << time;
        }
      }
    }
  }
}

/// Small images of one mesh from many places: from afar, along its surface, inside it, through it.
TEST_F(Levels, ClustersOfOneMeshShowEveryPixelFromAnywhere) {
  constexpr int kSmallWidth = 48, kSmallHeight = 32;
  core::Scene scene;
  core::Mesh torus = bumpy_torus(92, 0.1);  // of radii 3 and 1, about z
  ASSERT_GT(torus.indices.size(), 3 * lod::kLargeMesh);
  scene.add_mesh_instance(scene.root(), scene.add_mesh(std::move(torus)).value(), {});
  ASSERT_TRUE(scene.commit());
  engine::EngineConfig c = config_of({}, 0.0);
  c.width = kSmallWidth;
  c.height = kSmallHeight;
  engine::Engine clusters = create(scene, c);
  Whole whole(*context, scene, kSmallWidth, kSmallHeight);
  std::mt19937_64 random(5);
  for (int i = 0; i < repeated(10000, 30); ++i) {
    SCOPED_TRACE(i);
    const double around = between(random, 0, 6.3), distance = std::pow(10.0, between(random, -2, 1.5));
    const core::dvec3 ring(3.0 * std::cos(around), 3.0 * std::sin(around), 0.0);
    const core::dvec3 towards(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1));
    const core::dvec3 eye = ring + distance * towards;
    const core::dvec3 target(between(random, -4, 4), between(random, -4, 4), between(random, -1, 1));
    core::View view = *core::View::perspective({eye, target}, between(random, 0.05, 2.5), 1.5, 0.001);
    if (i % 5 == 0) view = *core::View::orthographic({eye, target}, between(random, 0.05, 12.0), 1.5, -5.0, 30.0);
    if (i % 4 == 0) view.sections.push_back({glm::normalize(towards), -glm::dot(glm::normalize(towards), ring)});
    const render::RenderTarget& drawn = whole.draw(view);
    const image::IdImage wanted = drawn.read_ids();
    const std::vector<float> depth = drawn.read_depth(view).metres;
    ASSERT_EQ(ids_of(clusters, view).ids, wanted.ids);
    ASSERT_EQ(clusters.read_depth(view)->metres, depth);
  }
}

/// Clusters of one mesh that its own front hides are left out.
TEST_F(Levels, LeaveOutClustersThatOthersHide) {
  core::Scene scene;
  core::Mesh sheets;  // eight, one behind the other
  for (int i = 0; i < 8; ++i) sheets = joined(std::move(sheets), terrain(60, 0.1), {0, 0, -4.0f * float(i)});
  scene.add_mesh_instance(scene.root(), scene.add_mesh(std::move(sheets)).value(), {});
  ASSERT_TRUE(scene.commit());
  for (const double error : {0.0, 0.5}) {
    engine::EngineConfig c = config_of({}, error);
    engine::Engine all = create(scene, c);
    c.culling.occlusion = engine::OcclusionChoice::kOn;
    engine::Engine open = create(scene, c);
    for (int i = 0; i < 6; ++i) {
      SCOPED_TRACE(testing::Message() << error << " px, view " << i);
      const core::dvec3 centre(5.0, 5.0, 0.0);
      const core::View view =
          *core::View::perspective({centre + core::dvec3(0.1 * i, 0.0, 12.0), centre}, 0.4, 1.5, 0.1);
      ASSERT_EQ(ids_of(open, view).ids, ids_of(all, view).ids);
      ASSERT_EQ(open.read_depth(view)->metres, all.read_depth(view)->metres);
      const std::int64_t whole = all.frame(view)->triangles, drawn = open.frame(view)->triangles;
      EXPECT_LT(drawn, whole / 3);
      EXPECT_GT(drawn, whole / 20);
      EXPECT_EQ(open.loss(view)->full_triangles, all.loss(view)->full_triangles);
    }
  }
}

TEST_P(LevelsByAny, FollowEditsAndNewVersions) {
  core::Scene scene;
  fill(scene);
  engine::Engine coarse = create(scene, 4.0, GetParam());
  const core::View view = look(40.0, 1.0);
  ids_of(coarse, view);
  const auto other = scene.add_mesh(bumpy_torus(30, 0.3)).value();
  scene.remove_item(items[0]);
  scene.add_mesh_instance(scene.root(), other, core::translation({0.0, 0.0, 1.0}));
  ASSERT_TRUE(scene.commit());
  ASSERT_TRUE(coarse.commit());
  ASSERT_TRUE(coarse.finish_levels());
  engine::Engine fresh = create(scene, 4.0, GetParam());
  EXPECT_EQ(ids_of(coarse, view).ids, ids_of(fresh, view).ids);
  ASSERT_TRUE(coarse.rebuild());
  ASSERT_TRUE(coarse.finish_levels());
  EXPECT_EQ(ids_of(coarse, view).ids, ids_of(fresh, view).ids);
}

/// Meshes come and go while levels are built and uploaded: places in GPU memory are given back, and what is drawn is
/// right.
TEST_P(LevelsByAny, ComeAndGoWithTheirMeshes) {
  core::Scene scene;
  fill(scene);
  engine::Engine coarse = create(scene, 2.0, GetParam());
  std::vector<core::ItemId> mine;
  std::vector<core::MeshId> meshes;
  std::size_t settled = 0;
  const int rounds = repeated(400);
  for (int round = 0; round < rounds; ++round) {
    SCOPED_TRACE(round);
    meshes.push_back(scene.add_mesh(bumpy_torus(std::uint32_t(12 + 5 * (round % 4)), 0.02 * (round % 7))).value());
    mine.push_back(
        scene.add_mesh_instance(scene.root(), meshes.back(), core::translation({3.0 * (round % 6), 4.0, 1.0})));
    if (mine.size() > 5) {
      scene.remove_item(mine.front());
      scene.remove_mesh(meshes.front());
      mine.erase(mine.begin());
      meshes.erase(meshes.begin());
    }
    ASSERT_TRUE(scene.commit());
    ASSERT_TRUE(coarse.commit());
    ASSERT_TRUE(coarse.frame(look(30.0, 0.1 * round)));
    ASSERT_TRUE(round % 9 != 8 || coarse.rebuild());
    if (round == rounds / 2) settled = coarse.memory().gpu;
  }
  ASSERT_TRUE(coarse.finish_levels());
  EXPECT_LE(coarse.memory().gpu, settled + settled / 4);
  engine::Engine fresh = create(scene, 2.0, GetParam());
  const core::View view = look(25.0, 2.5);
  EXPECT_EQ(ids_of(coarse, view).ids, ids_of(fresh, view).ids);
}

TEST_P(LevelsByAny, AreDrawnOnceTheyAreReady) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no coarser levels in this build";
  core::Scene scene;
  fill(scene);
  engine::EngineConfig c = config_of(GetParam(), 0.0);
  auto engine = engine::Engine::create(scene, c);
  ASSERT_TRUE(engine);
  const core::View view = look(60.0, 1.0);
  const image::IdImage full = ids_of(*engine, view);
  const std::size_t before = engine->memory().gpu;
  c.losses.lod_error = 6.0;
  ASSERT_TRUE(engine->configure(c));
  image::IdImage now = ids_of(*engine, view);
  for (int i = 0; i < 1000 && now.ids == full.ids; ++i) now = ids_of(*engine, view);
  EXPECT_NE(now.ids, full.ids);
  EXPECT_GT(engine->memory().gpu, before);
  c.losses.lod_error = 0.0;
  ASSERT_TRUE(engine->configure(c));
  EXPECT_EQ(ids_of(*engine, view).ids, full.ids);
}

TEST_F(Levels, TellWhatTheyCostTheImage) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no coarser levels in this build";
  core::Scene scene;
  fill(scene);
  const std::int64_t of_torus = std::int64_t(bumpy_torus(48, 0.05).indices.size() / 3);
  engine::EngineConfig c = config(engine::CullerChoice::kCpu, kWidth, kHeight);
  for (const bool occlusion : {false, true}) {
    SCOPED_TRACE(occlusion);
    c.culling.occlusion = occlusion ? engine::OcclusionChoice::kOn : engine::OcclusionChoice::kOff;
    c.losses = {};
    auto engine = engine::Engine::create(scene, c);
    ASSERT_TRUE(engine) << engine.error().message;
    const core::View view = look(60.0, 1.0);
    auto report = engine->frame(view);
    auto loss = engine->loss(view);
    EXPECT_EQ(report->triangles, 9 * of_torus);
    EXPECT_EQ(loss->triangles, 9 * of_torus);
    EXPECT_EQ(loss->full_triangles, 9 * of_torus);
    EXPECT_EQ(loss->lod_error, 0.0);
    EXPECT_EQ(loss->coarser_share, 0.0);
    double least = 0.0;
    for (const double error : {0.5, 2.0, 6.0}) {
      SCOPED_TRACE(error);
      c.losses.lod_error = error;
      ASSERT_TRUE(engine->configure(c));
      ASSERT_TRUE(engine->finish_levels());
      report = engine->frame(view);
      loss = engine->loss(view);
      EXPECT_LT(report->triangles, 9 * of_torus / 2);
      EXPECT_EQ(loss->triangles, report->triangles);
      EXPECT_EQ(loss->full_triangles, 9 * of_torus);
      EXPECT_LE(loss->lod_error, error);
      EXPECT_GT(loss->lod_error, least);
      EXPECT_EQ(loss->coarser_share, 1.0);
      EXPECT_EQ(loss->items, 0);
      least = loss->lod_error;
    }
    c.losses.budget_ms = 1000.0;
    ASSERT_TRUE(engine->configure(c));
    for (int i = 0; i < 3; ++i) {
      report = engine->frame(view);
      EXPECT_EQ(report->triangles, loss->triangles) << "of the image, also where the frame drew nothing more";
    }
    // A section opens some tori, which are then drawn in full where it cuts them.
    core::View cut = look(60.0, 1.0);
    cut.sections.push_back({{1, 0, 0}, -9.0});
    c.losses.budget_ms = 0.0;
    ASSERT_TRUE(engine->configure(c));
    ASSERT_TRUE(engine->frame(cut));
    EXPECT_GT(engine->loss(cut)->triangles, loss->triangles * 2 / 3 + of_torus / 4);
  }
}

/// Blended items are drawn over the image, and count like others, once for each image.
TEST_F(Levels, CountTrianglesOfItemsDrawnOverTheImage) {
  core::Scene scene;
  fill(scene);
  engine::EngineConfig c = config(engine::CullerChoice::kCpu, kWidth, kHeight);
  c.drawing.transparency = engine::Transparency::kBlended;
  for (const double budget : {0.0, 1000.0}) {
    c.losses.budget_ms = budget;
    auto engine = engine::Engine::create(scene, c);
    ASSERT_TRUE(engine) << engine.error().message;
    const core::View view = look(60.0, 1.0);
    const std::int64_t all = engine->frame(view)->triangles;
    engine::ItemStyle glass;
    glass.alpha = 0.5f;
    ASSERT_TRUE(engine->set_override(std::span(items).first(3), glass));
    for (int i = 0; i < 4; ++i) EXPECT_EQ(engine->frame(view)->triangles, all) << budget << " ms, frame " << i;
    EXPECT_EQ(engine->loss(view)->triangles, all);
  }
}

/// A budget that does not suffice draws coarser levels in motion than are asked for, says so, and ends in the same
/// image.
TEST_F(Levels, GetCoarserWhereABudgetDoesNotSuffice) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no coarser levels in this build";
  core::Scene scene;
  fill(scene);
  engine::EngineConfig c = config(engine::CullerChoice::kCpu, kWidth, kHeight);
  c.drawing.ids = true;
  c.losses.lod_error = 0.25;
  c.losses.budget_ms = 1e-3;
  auto engine = engine::Engine::create(scene, c);
  ASSERT_TRUE(engine) << engine.error().message;
  ASSERT_TRUE(engine->finish_levels());
  engine::EngineParts::set_traces_motion(*engine, false);
  double most = 0.0;
  for (int i = 0; i < 20; ++i) {
    const core::View view = look(20.0, 0.02 * i);
    const auto report = engine->frame(view);
    const auto loss = engine->loss(view);
    EXPECT_LE(loss->lod_error, 2.0);
    EXPECT_TRUE(report->pending > 0 || loss->lod_error <= 0.25) << "else the image would count as complete";
    most = std::max(most, loss->lod_error);
  }
  EXPECT_GT(most, 0.5);
  const core::View view = look(20.0, 0.4);
  for (int i = 0; i < 1000 && engine->frame(view)->pending > 0; ++i) {
  }
  EXPECT_LE(engine->loss(view)->lod_error, 0.25);
  engine::Engine patient = create(scene, 0.25);
  EXPECT_EQ(engine->read_ids()->ids, ids_of(patient, view).ids);
  // With time enough levels are those that are asked for.
  c.losses.budget_ms = 1e5;
  ASSERT_TRUE(engine->configure(c));
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(engine->frame(look(20.0, 0.02 * i)));
  EXPECT_LE(engine->loss(look(20.0, 0.58))->lod_error, 0.25);
}

/// Where placements scale equally, only rounding can tell the cuts apart, and it does so in hardly any view. With the
/// occlusion test a part that was hidden in the frame before shows in the same frame.
TEST_F(Levels, AreThoseOfTheCpuWhereTheGpuCulls) {
  core::Scene scene;
  const auto torus = scene.add_mesh(bumpy_torus(48, 0.05)).value(), hills = scene.add_mesh(terrain(60, 1.2)).value();
  std::mt19937_64 random(7);
  for (int i = 0; i < 40; ++i) {
    core::Affine at{between(random, 0.3, 1.2) * core::dmat3(0.6, 0.8, 0, -0.8, 0.6, 0, 0, 0, i % 2 ? 1 : -1), {}};
    at.origin = {between(random, 0, 30), between(random, 0, 30), between(random, 0, 10)};
    scene.add_mesh_instance(scene.root(), i % 4 ? torus : hills, at);
  }
  ASSERT_TRUE(scene.commit());
  std::vector<core::View> views;
  for (int i = 0; i < repeated(160, 20); ++i) {
    const core::dvec3 eye(between(random, -5, 35), between(random, -5, 35), between(random, -2, 12)), target(15, 15, 5);
    views.push_back(i % 4 == 0 ? *core::View::orthographic({eye, target}, between(random, 5, 40), 1.5, -20.0, 80.0)
                               : *core::View::perspective({eye, target}, between(random, 0.2, 1.5), 1.5, 0.05));
    if (i % 5 == 0) views.back().sections = {{{0, 0, 1}, -between(random, 0, 8)}};
  }
  constexpr double kErrors[] = {0.5, 0.0, 4.0};
  struct Image {
    std::vector<std::uint32_t> ids;
    std::vector<float> depth;
    bool operator==(const Image&) const = default;
  };
  /// By error and view.
  const auto images_of = [&](engine::EngineConfig c) {
    c.losses.lod_error = kErrors[0];
    engine::Engine engine = create(scene, c);
    std::vector<Image> images;
    for (const double error : kErrors) {
      c.losses.lod_error = error;
      EXPECT_TRUE(engine.configure(c));
      for (const core::View& view : views) {
        Image& image = images.emplace_back();
        image.ids = ids_of(engine, view).ids;
        image.depth = engine.read_depth(view)->metres;
      }
    }
    return images;
  };
  const std::vector<Image> cpu = images_of(config_of({}, 0.0));
  for (const culling::GpuVariant variant : {culling::GpuVariant::kGeometry, culling::GpuVariant::kCompute})
    for (const auto occlusion : {engine::OcclusionChoice::kOff, engine::OcclusionChoice::kOn}) {
      SCOPED_TRACE(testing::Message() << name_of(variant) << ", occlusion " << name_of(occlusion));
      engine::EngineConfig c = config_of({engine::CullerChoice::kGpu, variant}, 0.0);
      c.culling.occlusion = occlusion;
      const std::vector<Image> gpu = images_of(c);
      std::size_t other = 0;
      for (std::size_t i = 0; i < cpu.size(); ++i) {
        other += cpu[i] != gpu[i];
        if (kErrors[i / views.size()] == 0.0) {
          EXPECT_EQ(cpu[i], gpu[i]) << "in full, view " << i % views.size();
        }
      }
      EXPECT_LE(other, cpu.size() / 10);
    }
}

TEST_F(Levels, AreAHybridsOnEitherPath) {
  core::Scene scene;
  fill(scene);
  for (int i = 0; i < int(engine::kSmallHybridScene); ++i)
    scene.add_primitive(scene.root(), core::Box{0.1f, 0.1f, 0.1f},
                        core::translation({0.3 * (i % 100), 0.3 * (i / 100), -4}));
  ASSERT_TRUE(scene.commit());
  engine::EngineConfig c = config_of({engine::CullerChoice::kHybrid, {}}, 3.0);
  switch_often(c);
  engine::Engine hybrid = create(scene, c), cpu = create(scene, 3.0),
                 gpu = create(scene, 3.0, {engine::CullerChoice::kGpu, culling::GpuVariant::kCompute});
  ASSERT_EQ(name_of(hybrid.plan().culler), "hybrid");
  int frames_on_gpu = 0;
  constexpr int kFrames = 24;
  for (int i = 0; i < kFrames; ++i) {
    SCOPED_TRACE(i);
    const core::View view = look(30.0, 0.2 * i);
    const auto report = hybrid.frame(view);
    ASSERT_TRUE(report);
    const bool on_gpu = report->culler == engine::CullerChoice::kGpu;
    frames_on_gpu += on_gpu;
    ASSERT_EQ(hybrid.read_ids()->ids, ids_of(on_gpu ? gpu : cpu, view).ids);
  }
  EXPECT_GT(frames_on_gpu, 3);
  EXPECT_LT(frames_on_gpu, kFrames - 3);
}

/// What a GPU culls, only it could count.
TEST_F(Levels, OnAGpuCountNoTriangles) {
  core::Scene scene;
  fill(scene);
  auto on_gpu = engine::Engine::create(scene, config_of({engine::CullerChoice::kGpu, {}}, 1.0));
  ASSERT_TRUE(on_gpu) << on_gpu.error().message;
  EXPECT_EQ(on_gpu->frame(look(60.0, 1.0))->triangles, -1);
  EXPECT_EQ(on_gpu->loss(look(60.0, 1.0))->triangles, 0);
}

TEST_F(Levels, AreRefusedWhereTheErrorIsNone) {
  core::Scene scene;
  fill(scene);
  engine::EngineConfig c = config(engine::CullerChoice::kCpu, kWidth, kHeight);
  c.losses.lod_error = -1.0;
  EXPECT_FALSE(engine::Engine::create(scene, c));
}

/// Nobody has meshes here.
TEST_F(Levels, CostAGpuThatCullsNothingElsewhere) {
  core::Scene scene;
  DrawnGrid::fill(scene, 6);
  ASSERT_TRUE(scene.commit());
  for (const culling::GpuVariant variant : {culling::GpuVariant::kGeometry, culling::GpuVariant::kCompute}) {
    engine::Engine exact = create(scene, 0.0, {engine::CullerChoice::kGpu, variant});
    engine::Engine coarse = create(scene, 1.0, {engine::CullerChoice::kGpu, variant});
    ids_of(exact, look(30.0, 1.0));
    ids_of(coarse, look(30.0, 1.0));
    EXPECT_EQ(exact.memory().gpu, coarse.memory().gpu);
  }
}

}  // namespace
}  // namespace sightline::tests::levels_test
