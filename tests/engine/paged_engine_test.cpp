// Images drawn page by page are those of an engine that has everything in memory.
#include "sightline/engine/paged/paged_engine.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <future>
#include <limits>
#include <new>
#include <random>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

#include "sightline/engine/engine.h"
#include "sightline/engine/paged/internal/page_store.h"
#include "sightline/importers/import.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/importers/slc/paged_scene.h"
#include "sightline/importers/slc/slc_writer.h"
#include "sightline/lod/stored_levels.h"
#include "sightline/render/image/image.h"
#include "sightline/tests/importers/slc_bytes.h"
#include "sightline/tests/support/effort.h"
#include "sightline/tests/support/faulty_gl.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::engine {

/// Makes a paged engine in a context whose calls a test may let fail.
struct PagedEngineInContext {
  static core::Expected<PagedEngine> create(const gl::Context& context, core::PagedScene scene,
                                            const PagedConfig& config) {
    return PagedEngine::create_in(context.share(), std::move(scene), config);
  }
};

}  // namespace sightline::engine

namespace sightline::engine::paged_engine_test {
namespace {

namespace fs = std::filesystem;
using core::dvec3;
using core::View;

constexpr int kWidth = 320, kHeight = 180;
constexpr std::size_t kMany = std::size_t(8) << 30;

class PagedEngineTest : public tests::GlTest {
 protected:
  void SetUp() override {
    tests::GlTest::SetUp();
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) /
              ("sightline-paged-engine-" + std::string(info->name()) + "-" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override {
    fs::remove_all(folder_);
    tests::GlTest::TearDown();
  }

  std::string write(const core::Scene& scene, const importers::SlcWriteOptions& options = {}) const {
    EXPECT_TRUE(importers::write_slc(scene, folder_ / "scene.slc", options));
    return (folder_ / "scene.slc").string();
  }
  static core::PagedScene open(const std::string& file) {
    auto scene = importers::open_paged_scene(file);
    EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
    return scene ? std::move(*scene) : core::PagedScene();
  }
  static core::Expected<PagedEngine> engine(const std::string& file, std::size_t limit = kMany) {
    return PagedEngine::create(open(file),
                               {.width = kWidth, .height = kHeight, .drawing = {.ids = true}, .memory_limit = limit});
  }
  /// With little more room than the largest page takes, so that pages come and go all the time.
  static core::Expected<PagedEngine> tight_engine(const std::string& file) {
    std::size_t megabytes = 1;
    auto made = engine(file, megabytes << 20);
    EXPECT_FALSE(made);
    // What the process has in use grows from one try to the next, most of all under sanitizers and with drivers that
    // keep memory of contexts that ended.
    for (int i = 0; i < 5 && !made; ++i) {
      const std::size_t at = made.error().message.find("expected ");
      if (at == std::string::npos) break;
      megabytes = std::size_t(std::atoll(made.error().message.c_str() + at + 9)) + (8u << i);
      made = engine(file, megabytes << 20);
    }
    return made;
  }

  static View overview(const PagedEngine& paged) {
    return *View::fit(paged.scene().fitted.bounds, {1, 1, -0.7}, 0.8, double(kWidth) / kHeight);
  }

  /// Colours and depths to the bit. Ids, too, but where two items are at the same depth.
  static void expect_same_image(PagedEngine& paged, Engine& whole, const View& view) {
    const auto report = paged.settle(view, [](const PagedReport& so_far) {
      EXPECT_FALSE(so_far.complete);
      EXPECT_GT(so_far.pending, 0);
      return true;
    });
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->complete);
    EXPECT_EQ(report->pending, 0);
    EXPECT_EQ(report->placeholders, 0);
    ASSERT_TRUE(whole.frame(view));
    const auto depth = whole.read_depth(view);
    const auto ids = whole.read_ids();
    const auto colours = whole.read_colour();
    ASSERT_TRUE(depth && ids && colours);
    EXPECT_EQ(paged.read_depth().metres, depth->metres);
    const image::IdImage own = paged.read_ids();
    std::size_t others = 0;
    for (std::size_t i = 0; i < own.ids.size(); ++i) others += own.ids[i] != ids->ids[i];
    EXPECT_LE(others, own.ids.size() / 2000);
    const auto difference = image::compare(paged.read_colour(), *colours);
    ASSERT_TRUE(difference);
    EXPECT_LE(difference->pixels, others);
  }

  fs::path folder_;
};

/// All kinds of items, in layers, some hidden, some transparent, near and far.
core::Scene mixed_scene(std::mt19937& random, int items) {
  core::Scene scene;
  std::uniform_real_distribution<double> place(-20.0, 20.0), size(0.02, 0.8);
  const core::MaterialId glass = scene.add_material({.name = "glass", .colour = {0.2f, 0.5f, 0.9f}, .alpha = 0.5f});
  core::Mesh tetrahedron;
  tetrahedron.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  tetrahedron.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  const core::MeshId mesh = *scene.add_mesh(tetrahedron);
  for (int i = 0; i < items; ++i) {
    core::Affine where = core::translation(dvec3(1e6, 2e5, 0) + dvec3(place(random), place(random), place(random)));
    where.linear = core::dmat3(size(random));
    const auto node = scene.add_node(scene.root(), "n", where);
    if (i % 11 == 0) scene.set_layers(node, core::kLayerInsulation);
    if (i % 13 == 0) scene.set_visible(node, false);
    if (i % 7 == 0) scene.set_material(node, glass);
    switch (i % 6) {
      case 0:
        scene.add_primitive(node, core::Box{1, 2, 3});
        break;
      case 1:
        scene.add_primitive(node, core::CircularTorus{2, 0.5f, 2});
        break;
      case 2:
        scene.add_primitive(node, core::Snout{1, 0.5f, 2, 0.3f, 0, 0, 0, 0, 0});
        break;
      case 3:
        scene.add_mesh_instance(node, mesh);
        break;
      case 4:
        scene.add_primitive(node, core::Line{-1, 1});
        break;
      default:
        scene.add_primitive(node, core::Cylinder{0.3f, 3});
    }
  }
  return scene;
}

core::Scene plant(std::uint64_t items) {
  core::Scene scene;
  EXPECT_TRUE(importers::generate_plant({items, 5}, scene));
  return scene;
}

core::Expected<Engine> whole_engine(core::Scene& scene) {
  return Engine::create(scene, {.draw = true,
                                .width = kWidth,
                                .height = kHeight,
                                .culling = {.culler = CullerChoice::kCpu},
                                .drawing = {.ids = true}});
}

/// What is not in memory is shown by coarsest levels, and in the end nothing of these is left.
TEST_F(PagedEngineTest, CoarseLevelsStandInForPages) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no levels in this build";
  core::Scene scene = tests::scene_of_many_pages(500);
  ASSERT_TRUE(scene.commit());
  const std::string file = write(scene, {.levels = true});
  core::PagedScene paged = open(file);
  ASSERT_TRUE(paged.coarse);
  std::promise<void> allowed;
  paged.load = [load = paged.load, wait = allowed.get_future().share()](std::uint32_t page) {
    wait.wait();
    return load(page);
  };
  auto made = PagedEngine::create(std::move(paged), {.width = kWidth,
                                                     .height = kHeight,
                                                     .drawing = {.ids = true},
                                                     .memory_limit = kMany,
                                                     .refine_ms = 0.0,
                                                     .loading_bar = false});
  ASSERT_TRUE(made) << made.error().message;
  const View view = overview(*made);
  auto report = made->frame(view);
  for (int i = 0; i < 200 && report && report->coarse_resident < made->scene().pages.size(); ++i) {
    (void)made->wait(0.1);
    report = made->frame(view);
  }
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->complete);
  EXPECT_EQ(report->resident, 0u);
  EXPECT_EQ(report->placeholders, 0);
  EXPECT_GT(report->coarse_items, 300);
  auto whole = whole_engine(scene);
  ASSERT_TRUE(whole) << whole.error().message;
  ASSERT_TRUE(whole->frame(view));
  const auto drawn = whole->read_ids();
  ASSERT_TRUE(drawn);
  const image::IdImage rough = made->read_ids(), &exact = *drawn;
  std::size_t wrong = 0, covered = 0;
  for (std::size_t i = 0; i < exact.ids.size(); ++i)
    wrong += rough.ids[i] != exact.ids[i], covered += exact.ids[i] != core::to_index(core::kNoItem);
  EXPECT_GT(wrong, 0u);
  EXPECT_LT(wrong, covered / 5);
  allowed.set_value();
  expect_same_image(*made, *whole, view);
}

TEST_F(PagedEngineTest, CoarseLevelsKeepWithinTheLimit) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no levels in this build";
  core::Scene scene = tests::scene_of_many_pages(500);
  ASSERT_TRUE(scene.commit());
  const std::string file = write(scene, {.levels = true});
  auto paged = tight_engine(file);
  ASSERT_TRUE(paged) << paged.error().message;
  auto whole = whole_engine(scene);
  ASSERT_TRUE(whole) << whole.error().message;
  for (int i = 0; i < 4; ++i) {
    const dvec3 centre = paged->scene().fitted.bounds.centre();
    const dvec3 eye = centre + 40.0 * dvec3(std::cos(1.7 * i), std::sin(1.7 * i), 0.3);
    const View view = *View::perspective({eye, centre}, 0.9, double(kWidth) / kHeight, 0.1);
    for (int frame = 0; frame < 3; ++frame) {
      const auto report = paged->frame(view);
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_LE(paged->memory().pages, paged->memory().limit);
      (void)paged->wait(0.02);
    }
    expect_same_image(*paged, *whole, view);
  }
}

/// With an allowed error pages that coarse ones show as well are not read, and the others are drawn by their levels.
TEST_F(PagedEngineTest, LevelsOfDetailAreThoseOfTheWhole) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no levels in this build";
  core::Scene scene = tests::scene_of_many_pages(500);
  ASSERT_TRUE(scene.commit());
  const std::string file = write(scene, {.levels = true});
  auto paged = PagedEngine::create(open(file), {.width = kWidth,
                                                .height = kHeight,
                                                .drawing = {.ids = true},
                                                .losses = {.lod_error = 1.0},
                                                .memory_limit = kMany});
  ASSERT_TRUE(paged) << paged.error().message;
  auto whole = Engine::create(scene, {.draw = true,
                                      .width = kWidth,
                                      .height = kHeight,
                                      .culling = {.culler = CullerChoice::kCpu},
                                      .drawing = {.ids = true},
                                      .losses = {.lod_error = 1.0}});
  ASSERT_TRUE(whole) << whole.error().message;
  ASSERT_TRUE(whole->finish_levels());
  const dvec3 centre = paged->scene().fitted.bounds.centre();
  std::uint64_t loaded = 0;
  for (const double distance : {3000.0, 400.0, 150.0, 60.0, 20.0}) {
    const dvec3 eye = centre + distance * dvec3(0.6, 0.5, 0.6);
    const View view = *View::perspective({eye, centre}, 0.5, double(kWidth) / kHeight, 0.1);
    expect_same_image(*paged, *whole, view);
    const auto report = paged->frame(view);
    ASSERT_TRUE(report);
    if (distance == 3000.0) {
      EXPECT_EQ(report->loaded, 0u) << "far away";
    }
    loaded = report->loaded;
  }
  EXPECT_GT(loaded, 0u);
}

TEST_F(PagedEngineTest, SettledImagesAreThoseOfTheWhole) {
  const std::string file = write(plant(200'000));
  core::Scene scene;
  ASSERT_TRUE(importers::import_file(file, scene, scene.root()));
  auto whole = whole_engine(scene);
  ASSERT_TRUE(whole) << whole.error().message;
  const double aspect = double(kWidth) / kHeight;
  std::vector<View> views{*View::fit(whole->snapshot().bounds().world_bounds(), {1, 1, -0.7}, 0.8, aspect),
                          *View::perspective({{-30, -12, 6}, {5, 2, 3}, {0, 0, 1}}, 1.0, aspect, 0.1),
                          *View::perspective({{20, 4, 2}, {60, 10, 5}, {0, 0, 1}}, 1.2, aspect, 0.01, 500.0),
                          *View::orthographic({{0, 0, 100}, {0, 0, 0}, {0, 1, 0}}, 60.0, aspect, 1.0, 300.0)};
  View cut = views[1];
  cut.sections = {{{0, 1, 0}, -1.0}};
  views.push_back(cut);
  for (const bool tight : {false, true}) {
    auto paged = tight ? tight_engine(file) : engine(file);
    ASSERT_TRUE(paged) << paged.error().message;
    for (const View& view : views) expect_same_image(*paged, *whole, view);
    for (const std::string& error : paged->take_errors()) ADD_FAILURE() << error;
    EXPECT_LE(paged->memory().pages, paged->memory().limit);
  }
}

TEST_F(PagedEngineTest, AllKindsOfItemsLayersAndMaterials) {
  std::mt19937 random(11);
  const std::string file = write(mixed_scene(random, 40'000));
  core::Scene scene;
  ASSERT_TRUE(importers::import_file(file, scene, scene.root()));
  auto whole = whole_engine(scene);
  ASSERT_TRUE(whole) << whole.error().message;
  auto paged = engine(file);
  ASSERT_TRUE(paged) << paged.error().message;
  EXPECT_GT(paged->scene().pages.size(), 1u);
  std::uniform_real_distribution<double> place(-25.0, 25.0);
  for (int i = 0; i < 12; ++i) {
    SCOPED_TRACE("seed 11, view " + std::to_string(i));
    const dvec3 middle(1e6, 2e5, 0);
    const core::Pose pose{middle + dvec3(place(random), place(random), place(random)),
                          middle + 0.3 * dvec3(place(random), place(random), place(random)),
                          {0, 0, 1}};
    View view = *View::perspective(pose, 1.0, double(kWidth) / kHeight, 0.05);
    if (i % 3 == 1) view.layers = core::kLayerInsulation;
    if (i % 3 == 2) view.layers = core::kLayerModel | core::kLayerInsulation;
    if (i % 4 == 3) view.sections = {{{0, 0.6, 0.8}, -0.6 * middle.y}, {{1, 0, 0}, 5.0 - middle.x}};
    expect_same_image(*paged, *whole, view);
  }
}

/// One with layers, glass and lines, one without, far from each other's origins. Last bits may differ.
TEST_F(PagedEngineTest, PartsOfAFolderKeepWhatEachHas) {
  std::mt19937 random(12);
  const core::Scene layered = mixed_scene(random, 6000);
  core::Scene plain;
  std::uniform_real_distribution<double> place(-20.0, 20.0);
  for (int i = 0; i < 3000; ++i) {
    const dvec3 at = dvec3(1e6, 2e5, 0) + dvec3(place(random), place(random), place(random));
    plain.add_primitive(plain.add_node(plain.root(), "s", core::translation(at)), core::Sphere{0.5f});
  }
  plain.add_primitive(plain.add_node(plain.root(), "far", core::translation({0, 0, 0})), core::Box{1, 1, 1});
  const fs::path folder = folder_ / "parts";
  fs::create_directory(folder);
  core::Scene scene;
  for (const auto& [name, part] : {std::pair("a.slc", &layered), {"b.slc", &std::as_const(plain)}}) {
    ASSERT_TRUE(importers::write_slc(*part, folder / name));
    ASSERT_TRUE(importers::import_file(folder / name, scene, scene.root()));
  }
  auto whole = whole_engine(scene);
  auto paged = engine(folder.string());
  ASSERT_TRUE(whole && paged);
  const dvec3 middle(1e6, 2e5, 0);
  View view = *View::perspective({middle + dvec3(30, -30, 12), middle, {0, 0, 1}}, 0.9, double(kWidth) / kHeight, 0.1);
  for (const std::uint32_t layers :
       {core::kDefaultLayerMask, core::kLayerInsulation, std::uint32_t(core::kLayerModel)}) {
    SCOPED_TRACE(layers);
    view.layers = layers;
    const auto report = paged->settle(view);
    ASSERT_TRUE(report && whole->frame(view));
    EXPECT_TRUE(report->complete);
    const auto ids = whole->read_ids();
    const image::IdImage own = paged->read_ids();
    std::size_t others = 0, plain_pixels = 0;
    for (std::size_t i = 0; i < own.ids.size(); ++i) {
      others += own.ids[i] != ids->ids[i];
      plain_pixels += own.ids[i] > 6000;
    }
    EXPECT_LE(others, own.ids.size() / 500);
    EXPECT_EQ(plain_pixels > 0, layers != core::kLayerInsulation);
    const auto difference = image::compare(paged->read_colour(), *whole->read_colour());
    ASSERT_TRUE(difference);
    EXPECT_LE(difference->mean, 0.05);
  }
}

TEST_F(PagedEngineTest, ASmallLimitGivesUpPagesAndLosesNothing) {
  const std::string file = write(plant(600'000));
  auto small = tight_engine(file), large = engine(file);
  ASSERT_TRUE(small && large);
  const View view = *View::fit(small->scene().fitted.bounds, {1, 1, -0.7}, 0.8, double(kWidth) / kHeight);
  const auto least = small->settle(view), most = large->settle(view);
  ASSERT_TRUE(least && most);
  EXPECT_GT(least->evicted, 0u);
  EXPECT_EQ(most->evicted, 0u);
  EXPECT_EQ(small->read_colour().pixels, large->read_colour().pixels);
  EXPECT_LE(small->memory().pages, small->memory().limit);
  // Complete images stay as they are, and ask for nothing. A page that what came before it hides may be under way.
  auto rest = least;
  while (small->wait(60.0)) rest = small->frame(view);
  const auto again = small->frame(view);
  ASSERT_TRUE(rest && again);
  EXPECT_TRUE(again->complete);
  EXPECT_EQ(again->loaded, rest->loaded);
  EXPECT_EQ(again->items_drawn, least->items_drawn);
  EXPECT_FALSE(small->wait(0.0));
}

TEST_F(PagedEngineTest, WhatIsMissingIsStoodInFor) {
  const std::string file = write(plant(100'000));
  auto paged = engine(file);
  ASSERT_TRUE(paged);
  const View view = *View::fit(paged->scene().fitted.bounds, {1, 1, -0.7}, 0.8, double(kWidth) / kHeight);
  const auto first = paged->frame(view);
  ASSERT_TRUE(first);
  EXPECT_FALSE(first->complete);
  EXPECT_EQ(first->pending, first->leaves);
  EXPECT_GT(first->placeholders, 100);
  EXPECT_EQ(first->items_drawn, 0);
  const image::Image coarse = paged->read_colour();
  for (const std::uint32_t id : paged->read_ids().ids) ASSERT_EQ(id, 0u);
  // Placeholders cover about what the model does.
  ASSERT_TRUE(paged->settle(view));
  const image::Image fine = paged->read_colour();
  const auto is_background = [](const image::Image& image, std::size_t pixel) {
    return std::memcmp(&image.pixels[3 * pixel], &image.pixels[0], 3) == 0;
  };
  std::size_t covered = 0, both = 0;
  for (std::size_t i = 0; i < fine.pixels.size() / 3; ++i) {
    covered += !is_background(fine, i);
    both += !is_background(fine, i) && !is_background(coarse, i);
  }
  EXPECT_GT(both, covered * 9 / 10);
}

TEST_F(PagedEngineTest, PagesAreReadAheadOfTheCamera) {
  const std::string file = write(plant(400'000));
  auto paged = engine(file);
  ASSERT_TRUE(paged);
  // Sideways along the plant with a narrow view: what comes into view next is not in view now.
  std::uint64_t ahead = 0;
  for (int i = 0; i < 40; ++i) {
    const dvec3 eye(-180.0 + 4.0 * i, -40.0, 10.0);
    const auto report =
        paged->frame(*View::perspective({eye, eye + dvec3(0, 1, -0.1), {0, 0, 1}}, 0.3, double(kWidth) / kHeight, 0.1));
    ASSERT_TRUE(report);
    ahead = std::max(ahead, report->prefetched);
    (void)paged->wait(10.0);
  }
  EXPECT_GT(ahead, 0u);
}

#if SIGHTLINE_HAS_RAYTRACE

class MovingPagesTest : public PagedEngineTest {
 protected:
  static PagedConfig config(double budget_ms, std::size_t limit = kMany) {
    return {.width = kWidth,
            .height = kHeight,
            .drawing = {.ids = true},
            .losses = {.budget_ms = budget_ms},
            .memory_limit = limit,
            .loading_bar = false};
  }
  /// A view of the plant, and others beside it.
  static View beside(const PagedEngine& paged, int step) {
    const core::AabbD& box = paged.scene().fitted.bounds;
    const dvec3 direction(std::cos(0.002 * step), std::sin(0.002 * step), -0.5);
    return *View::fit(box, direction, 0.8, double(kWidth) / kHeight);
  }
};

TEST_F(MovingPagesTest, ShowWhatIsInMemoryByRays) {
  core::Scene scene = plant(60'000);
  const std::string file = write(scene);
  auto paged = PagedEngine::create(open(file), config(1e5));
  ASSERT_TRUE(paged) << paged.error().message;
  ASSERT_TRUE(paged->settle(beside(*paged, 0)));
  const View view = beside(*paged, 5);
  const auto report = paged->frame(view);
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->complete);
  EXPECT_EQ(report->pending, 0);
  EXPECT_EQ(report->coarseness, 1.0);
  EXPECT_EQ(report->earlier, 0.0) << "there was no traced image before";
  auto whole = Engine::create(scene, {.draw = true, .width = kWidth, .height = kHeight, .drawing = {.ids = true}});
  ASSERT_TRUE(whole && whole->frame(view));
  const auto ids = whole->read_ids();
  const image::IdImage own = paged->read_ids();
  std::size_t same = 0;
  for (std::size_t i = 0; i < own.ids.size(); ++i) same += own.ids[i] == ids->ids[i];
  EXPECT_GT(same, own.ids.size() * 98 / 100) << "rays and rasteriser differ in edges";
  EXPECT_LT(std::ranges::count(own.ids, 0u), std::ptrdiff_t(own.ids.size()) * 95 / 100);
  ASSERT_TRUE(paged->settle(view));
  EXPECT_EQ(paged->read_depth().metres, whole->read_depth(view)->metres) << "at rest it is drawn";
  ASSERT_TRUE(paged->frame(beside(*paged, 6)));
  ASSERT_TRUE(paged->frame(view));
  const auto again = paged->frame(view);
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->complete);
  EXPECT_GT(again->leaves, 0) << "nothing of the traced image's report stays";
  EXPECT_EQ(again->earlier, 0.0);
}

TEST_F(MovingPagesTest, ShowBoxesOfWhatIsMissingAndReadIt) {
  const std::string file = write(plant(300'000));
  auto paged = PagedEngine::create(open(file), config(1.0));
  ASSERT_TRUE(paged) << paged.error().message;
  auto report = paged->frame(beside(*paged, 0));
  ASSERT_TRUE(report);
  EXPECT_GT(report->pending, 0);
  EXPECT_EQ(std::ranges::count(paged->read_ids().ids, 0u), kWidth * kHeight);
  const auto metres = paged->read_depth().metres;
  EXPECT_GT(std::ranges::count_if(metres, [](float m) { return std::isfinite(m); }), kWidth * kHeight / 20);
  for (int step = 1; step < 600 && report && report->pending > 0; ++step) {
    (void)paged->wait(0.05);
    report = paged->frame(beside(*paged, step % 20));
  }
  ASSERT_TRUE(report);
  EXPECT_EQ(report->pending, 0) << "boxes of pages that are there show for " << report->frame << " frames";
  EXPECT_GT(report->loaded, 0u);
  EXPECT_GT(report->earlier, 0.0);
  EXPECT_LT(std::ranges::count(paged->read_ids().ids, 0u), kWidth * kHeight * 95 / 100);
}

/// However little memory pages have, they come and go, and the image at rest is complete.
TEST_F(MovingPagesTest, KeepWithinTheLimit) {
  const std::string file = write(plant(300'000));
  const auto refused = PagedEngine::create(open(file), config(1.0, std::size_t(1) << 20));
  ASSERT_FALSE(refused);
  const std::size_t at = refused.error().message.find("expected ");
  ASSERT_NE(at, std::string::npos);
  const std::size_t megabytes = std::size_t(std::atoll(refused.error().message.c_str() + at + 9));
  auto paged = PagedEngine::create(open(file), config(1.0, (megabytes + 24) << 20));
  ASSERT_TRUE(paged) << paged.error().message;
  std::uint64_t evicted = 0;
  for (int step = 0; step < 120; ++step) {
    const View view =
        *View::perspective({{-180.0 + 3.0 * step, -40.0, 20.0}, {-180.0 + 3.0 * step, 0.0, 0.0}, {0, 0, 1}}, 0.9,
                           double(kWidth) / kHeight, 0.1);
    const auto report = paged->frame(view);
    ASSERT_TRUE(report);
    const PagedEngine::Memory memory = paged->memory();
    EXPECT_TRUE(memory.pages <= memory.limit || report->resident == 0) << "pages on their way cannot be given back";
    evicted = report->evicted;
    (void)paged->wait(0.02);
  }
  EXPECT_GT(evicted, 0u);
  const auto rest = paged->settle(beside(*paged, 0));
  ASSERT_TRUE(rest);
  EXPECT_TRUE(rest->complete);
}

#else

TEST_F(PagedEngineTest, ABudgetNeedsRays) {
  const auto refused =
      PagedEngine::create(open(write(plant(1'000))), {.losses = {.budget_ms = 33.0}, .memory_limit = kMany});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("traces no rays"), std::string::npos);
}

#endif

TEST_F(PagedEngineTest, ALimitThatIsTooLowSaysWhatIsNeeded) {
  const std::string file = write(plant(50'000));
  const auto refused = engine(file, std::size_t(1) << 20);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("memory limit of 1 MiB is too low"), std::string::npos);
  EXPECT_TRUE(tight_engine(file));
}

TEST_F(PagedEngineTest, RoomForOnePageStaysInAnyCase) {
  const core::PagedScene scene = open(write(plant(50'000)));
  PageStore store(scene, 1, false);
  EXPECT_EQ(store.limit(), PageStore::largest_page(scene));
  const PageStore::Wanted wanted{0, 1.0f, true};
  store.ask_for({&wanted, 1}, 0, true);
  EXPECT_TRUE(store.wait(60.0));
  store.take_loaded(0);
  ASSERT_TRUE(store.upload(*context));
  ASSERT_TRUE(store.find(0));
  EXPECT_EQ(store.bytes(), store.resident_bytes());
  store.set_limit(0);
  EXPECT_EQ(store.limit(), PageStore::largest_page(scene));
  EXPECT_LE(store.bytes(), store.limit());
  store.set_limit(std::size_t(1) << 40);
  EXPECT_EQ(store.limit(), std::size_t(1) << 40);
}

TEST_F(PagedEngineTest, ADamagedPageIsToldAndTheOthersAreDrawn) {
  const std::string file = write(plant(150'000));
  auto paged = engine(file);
  ASSERT_TRUE(paged);
  // In the middle of the file lie arrays of pages.
  std::fstream damage(file, std::ios::in | std::ios::out | std::ios::binary);
  damage.seekp(std::streamoff(fs::file_size(file) / 3));
  damage.write("damage", 6);
  damage.close();
  const View view = *View::fit(paged->scene().fitted.bounds, {1, 1, -0.7}, 0.8, double(kWidth) / kHeight);
  const auto report = paged->settle(view);
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->complete);
  EXPECT_EQ(report->failed, 1u);
  EXPECT_GT(report->items_drawn, 1000);
  EXPECT_GT(report->placeholders, 0);
  const auto errors = paged->take_errors();
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_NE(errors[0].find("it does not match its checksum"), std::string::npos) << errors[0];
}

TEST_F(PagedEngineTest, ALoaderThatThrowsLosesItsPagesAlone) {
  core::PagedScene scene = open(write(plant(150'000)));
  scene.load = [read = scene.load](std::uint32_t page) {
    if (page == 1) throw std::bad_alloc();
    if (page == 2) throw std::runtime_error("no disk");
    return read(page);
  };
  auto paged = PagedEngine::create(
      std::move(scene), {.width = kWidth, .height = kHeight, .drawing = {.ids = true}, .memory_limit = kMany});
  ASSERT_TRUE(paged) << paged.error().message;
  const auto report = paged->settle(overview(*paged));
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->complete);
  EXPECT_EQ(report->failed, 2u);
  std::vector<std::string> errors = paged->take_errors();
  std::sort(errors.begin(), errors.end());
  EXPECT_EQ(errors, (std::vector<std::string>{"no disk", "out of memory"}));
}

TEST_F(PagedEngineTest, ProgressMayUseAnotherContext) {
  const std::string file = write(plant(150'000));
  auto alone = engine(file), among = engine(file);
  ASSERT_TRUE(alone && among);
  const View view = overview(*alone);
  ASSERT_TRUE(alone->settle(view));
  int told = 0;
  const auto report = among->settle(view, [&](const PagedReport&) {
    EXPECT_TRUE(context->make_current());
    return ++told > 0;
  });
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_GT(told, 0);
  EXPECT_EQ(among->read_colour().pixels, alone->read_colour().pixels);
  EXPECT_TRUE(context->make_current());
}

TEST_F(PagedEngineTest, NoMemoryIsAnError) {
  auto paged = engine(write(plant(50'000)));
  ASSERT_TRUE(paged);
  const auto report = paged->settle(overview(*paged), [](const PagedReport&) -> bool { throw std::bad_alloc(); });
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("not enough memory"), std::string::npos) << report.error().message;
}

TEST_F(PagedEngineTest, AFrameOfAViewThatStaysTakesItsTime) {
  auto paged = PagedEngine::create(open(write(plant(150'000))), {.width = kWidth,
                                                                 .height = kHeight,
                                                                 .memory_limit = kMany,
                                                                 .refine_ms = std::numeric_limits<double>::infinity()});
  ASSERT_TRUE(paged) << paged.error().message;
  const View view = overview(*paged);
  const auto first = paged->frame(view), second = paged->frame(view);
  ASSERT_TRUE(first && second);
  EXPECT_FALSE(first->complete);
  EXPECT_TRUE(second->complete);
  EXPECT_EQ(first->frame + 1, second->frame);
}

TEST_F(PagedEngineTest, ABarSaysThatTheImageIsNotComplete) {
  const std::string file = write(plant(50'000));
  std::vector<image::Image> images;
  for (const bool bar : {false, true}) {
    auto paged = PagedEngine::create(
        open(file), {.width = kWidth, .height = kHeight, .memory_limit = kMany, .refine_ms = 0.0, .loading_bar = bar});
    ASSERT_TRUE(paged) << paged.error().message;
    const auto first = paged->frame(overview(*paged));
    ASSERT_TRUE(first);
    ASSERT_FALSE(first->complete);
    images.push_back(paged->read_colour());
  }
  ASSERT_EQ(images[0].pixels.size(), images[1].pixels.size());
  int changed = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const std::size_t at = 3 * (std::size_t(y) * kWidth + std::size_t(x));
      if (std::memcmp(&images[0].pixels[at], &images[1].pixels[at], 3) == 0) continue;
      ++changed;
      EXPECT_GT(y, kHeight * 9 / 10);
      EXPECT_LT(x, kWidth / 4);
    }
  EXPECT_GT(changed, 100);
}

TEST_F(PagedEngineTest, AViewThatCannotBeDrawnIsRefusedAndTheNextIsDrawn) {
  auto paged = engine(write(plant(50'000)));
  ASSERT_TRUE(paged);
  const View good = overview(*paged);
  ASSERT_TRUE(paged->settle(good));
  const image::Image before = paged->read_colour();
  const View combined = *View::from_matrices(core::dmat4(1.0), good.clip_from_world(), good.clip_depth());
  EXPECT_FALSE(paged->settle(combined));
  ASSERT_TRUE(paged->settle(good));
  EXPECT_EQ(paged->read_colour().pixels, before.pixels);
}

TEST_F(PagedEngineTest, EndsWhilePagesAreReadAndMoves) {
  const std::string file = write(plant(150'000));
  for (int i = 0; i < 5; ++i) {
    auto paged = engine(file);
    ASSERT_TRUE(paged);
    const View view = overview(*paged);
    ASSERT_TRUE(paged->frame(view));
    if (i % 2 == 0) continue;
    PagedEngine moved = std::move(*paged);
    ASSERT_TRUE(moved.frame(view));
    *paged = std::move(moved);
    ASSERT_TRUE(paged->settle(view)->complete);
  }
}

TEST_F(PagedEngineTest, WaitsForEverWhenAsked) {
  core::PagedScene scene = open(write(plant(50'000)));
  std::promise<void> go;
  std::atomic<int> asked{0};
  scene.load = [&asked, read = scene.load, may_go = go.get_future().share()](std::uint32_t page) {
    ++asked;
    may_go.wait();
    return read(page);
  };
  const std::jthread later([&](const std::stop_token& stop) {
    while (asked == 0 && !stop.stop_requested()) std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    go.set_value();
  });
  auto paged = PagedEngine::create(std::move(scene), {.width = kWidth, .height = kHeight, .memory_limit = kMany});
  ASSERT_TRUE(paged) << paged.error().message;
  const View view = overview(*paged);
  ASSERT_TRUE(paged->frame(view));
  for (const double none : {0.0, -1.0, -std::numeric_limits<double>::infinity(), std::nan("")})
    EXPECT_TRUE(paged->wait(none));
  EXPECT_TRUE(paged->wait(std::numeric_limits<double>::infinity()));
  EXPECT_GE(paged->frame(view)->loaded, 1u);
}

/// A call that fails for want of memory, or is refused, makes the engine's call fail, which works when it is made
/// again. `count`: calls that fail, from a number on.
void fail_while_pages_come(gl::Context& context, const std::function<core::PagedScene()>& open, int count) {
  const PagedConfig config{
      .width = kWidth, .height = kHeight, .drawing = {.ids = true}, .memory_limit = kMany, .loading_bar = false};
  tests::FaultyGl faulty(context);
  std::optional<PagedEngine> paged;
  core::Expected<PagedReport> report;
  const auto create = [&]() -> core::Expected<void> {
    auto made = PagedEngineInContext::create(context, open(), config);
    if (!made) return tl::unexpected(made.error());
    paged = std::move(*made);
    return {};
  };
  const auto settle = [&]() -> core::Expected<void> {
    const View view = *View::fit(paged->scene().fitted.bounds, {1, 1, -0.7}, 0.8, double(kWidth) / kHeight);
    report = paged->settle(view);
    return report.map([](const PagedReport&) {});
  };
  int errors = 0, fallible = 0, tries = 0;
  image::Image wanted;
  for (int i = 0; i < 2; ++i) {  // the first run may have to compile programs
    faulty.reset();
    ASSERT_TRUE(create() && settle());
    fallible = faulty.fallible();
    wanted = paged->read_colour();
    paged.reset();
  }
  std::mt19937 random(43);
  const int step = tests::long_run() ? 1 : fallible / 12;
  for (int number = int(random() % unsigned(step)); number < fallible; number += step, ++tries) {
    SCOPED_TRACE("call " + std::to_string(number) + " of " + std::to_string(fallible));
    faulty.reset();
    faulty.fail(number, count);
    for (const std::function<core::Expected<void>()>& call :
         {std::function<core::Expected<void>()>(create), {settle}}) {
      auto done = call();
      if (!done) {
        ++errors;
        EXPECT_FALSE(done.error().message.empty());
        if (paged) (void)settle();
        (void)context.take_errors();
        faulty.stop();
        done = call();
      }
      ASSERT_TRUE(done) << "after " << faulty.failed_first() << ": " << done.error().message;
      for (const std::string& error : context.take_errors())
        if (error != "GetError: GL_OUT_OF_MEMORY") ADD_FAILURE() << "GL error left: " << error;
    }
    EXPECT_TRUE(report->complete);
    EXPECT_EQ(paged->read_colour().pixels, wanted.pixels) << "after " << faulty.failed_first();
    paged.reset();
  }
  std::printf("%d of %d calls that may fail: %d errors, %d not noticed\n", tries, fallible, errors, tries - errors);
}

TEST_F(PagedEngineTest, CallsThatFailWorkWhenTheyAreMadeAgain) {
  std::mt19937 random(5);
  const std::string file = write(mixed_scene(random, 2000));
  for (const int count : {1, tests::FaultyGl::kForever})
    fail_while_pages_come(
        *context, [&] { return open(file); }, count);
}

TEST_F(PagedEngineTest, AContextThatIsLostIsAnError) {
  std::mt19937 random(5);
  const std::string file = write(mixed_scene(random, 500));
  for (int i = 0; i < tests::repeated(100); ++i) {
    auto made = gl::Context::create_offscreen();
    ASSERT_TRUE(made);
    tests::FaultyGl faulty(*made);
    faulty.lose(int(random() % 4000));
    auto paged =
        PagedEngineInContext::create(*made, open(file), {.width = kWidth, .height = kHeight, .memory_limit = kMany});
    for (int frame = 0; frame < 3 && paged; ++frame) {
      const auto report = paged->settle(overview(*paged));
      EXPECT_EQ(bool(report), !faulty.lost());
    }
  }
}

TEST_F(PagedEngineTest, AnEmptySceneIsComplete) {
  auto paged = engine(write(core::Scene()));
  ASSERT_TRUE(paged) << paged.error().message;
  const auto report = paged->frame(*View::perspective({{0, 0, 5}, {0, 0, 0}, {0, 1, 0}}, 1.0, 16.0 / 9.0, 0.1));
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->complete);
}

}  // namespace
}  // namespace sightline::engine::paged_engine_test
