// Scenes larger than memory in C: images and reports are those of C++, and what is refused.
#include <atomic>
#include <cmath>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <unistd.h>

#include "each_setting.h"
#include "sightline/engine/paged/paged_engine.h"
#include "sightline/importers/slc/paged_scene.h"
#include "sightline/importers/slc/slc_writer.h"
#include "sightline/lod/stored_levels.h"
#include "sightline/render/image/image.h"
#include "sightline/tests/importers/many_pages.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests::paged_test {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr std::size_t kMany = std::size_t(8) << 30;

/// One view in both APIs, from so many metres off the scene's middle.
struct View {
  sl_view c = SL_VIEW_INIT;
  core::View cpp;

  View(const core::dvec3& centre, double distance)
      : cpp(*core::View::perspective({centre + distance * core::dvec3(0.6, 0.5, 0.6), centre}, 0.5,
                                     double(kWidth) / kHeight, 0.1)) {
    const core::dvec3 eye = centre + distance * core::dvec3(0.6, 0.5, 0.6);
    const sl_pose pose = {{eye.x, eye.y, eye.z}, {centre.x, centre.y, centre.z}, {0, 0, 1}};
    EXPECT_OK(sl_view_perspective(&pose, 0.5, double(kWidth) / kHeight, 0.1, HUGE_VAL, &c));
  }
};

class CapiPaged : public GlTest {
 protected:
  /// Writes the file once. Each test has a copy, which it may damage.
  static void SetUpTestSuite() {
    core::Scene scene = scene_of_many_pages(500);
    ASSERT_TRUE(scene.commit());
    ASSERT_TRUE(importers::write_slc(scene, file_of("whole"), {.levels = lod::builds_levels()}));
  }
  static void TearDownTestSuite() { std::filesystem::remove(file_of("whole")); }
  void SetUp() override {
    GlTest::SetUp();
    std::filesystem::copy_file(file_of("whole"), file);
  }
  void TearDown() override {
    if (engine.id) {
      EXPECT_OK(sl_paged_engine_destroy(engine));
    }
    std::filesystem::remove(file);
    GlTest::TearDown();
  }

  static sl_paged_config config(double lod_error = 0.0) {
    sl_paged_config made = SL_PAGED_CONFIG_INIT;
    made.width = kWidth, made.height = kHeight;
    made.drawing.ids = 1;
    made.losses.lod_error = lod_error;
    made.memory_limit = kMany;
    made.context.program_cache = "";
    return made;
  }
  void make_engine(const sl_paged_config& with) {
    if (engine.id) {
      EXPECT_OK(sl_paged_engine_destroy(engine));
    }
    ASSERT_OK(sl_paged_engine_create(file.c_str(), &with, &engine));
  }
  engine::PagedEngine make_twin(double lod_error = 0.0) const {
    return std::move(
        *engine::PagedEngine::create(std::move(*importers::open_paged_scene(file)), {.width = kWidth,
                                                                                     .height = kHeight,
                                                                                     .drawing = {.ids = true},
                                                                                     .losses = {.lod_error = lod_error},
                                                                                     .memory_limit = kMany}));
  }

  static std::string file_of(const std::string& name) {
    return testing::TempDir() + "capi_paged_" + name + std::to_string(getpid()) + ".slc";
  }

  const std::string file = file_of("copy");
  sl_paged_engine engine = {0};
};

TEST_F(CapiPaged, DrawsWhatCppDraws) {
  for (const double lod_error : {0.0, 1.0}) {
    SCOPED_TRACE(lod_error);
    make_engine(config(lod_error));
    engine::PagedEngine twin = make_twin(lod_error);
    for (const double distance : {3000.0, 60.0}) {
      SCOPED_TRACE(distance);
      const View view(twin.scene().fitted.bounds.centre(), distance);
      sl_paged_report report = SL_PAGED_REPORT_INIT;
      ASSERT_OK(sl_paged_engine_settle(engine, &view.c, nullptr, nullptr, &report));
      const auto expected = twin.settle(view.cpp);
      ASSERT_TRUE(expected);
      EXPECT_EQ(report.complete, 1);
      EXPECT_EQ(report.leaves, expected->leaves);
      EXPECT_EQ(report.pending, 0);
      EXPECT_EQ(report.items_drawn, expected->items_drawn);
      EXPECT_EQ(report.failed, 0u);
      EXPECT_GT(report.frame_ms, 0.0);
      // Far away the coarsest levels are good enough, and no page is read in full.
      if (distance > 1000.0 && lod::builds_levels()) {
        EXPECT_EQ(report.loaded == 0, lod_error > 0.0);
        EXPECT_EQ(report.coarse_loaded > 0, lod_error > 0.0);
      }
      const auto pixels = std::size_t(kWidth) * kHeight;
      std::vector<std::uint8_t> rgb(3 * pixels);
      std::vector<std::uint32_t> ids(pixels);
      std::vector<float> metres(pixels);
      ASSERT_OK(sl_paged_engine_read_colour(engine, rgb.data(), rgb.size()));
      ASSERT_OK(sl_paged_engine_read_ids(engine, ids.data(), ids.size()));
      ASSERT_OK(sl_paged_engine_read_depth(engine, metres.data(), metres.size()));
      EXPECT_EQ(rgb, twin.read_colour().pixels);
      EXPECT_EQ(ids, twin.read_ids().ids);
      EXPECT_EQ(metres, twin.read_depth().metres);
      EXPECT_EQ(sl_paged_engine_read_colour(engine, rgb.data(), rgb.size() - 1), SL_ERROR_ARGUMENT);
    }
  }
}

TEST_F(CapiPaged, FramesGoOnWithTheImage) {
  make_engine(config());
  sl_paged_info info = SL_PAGED_INFO_INIT;
  ASSERT_OK(sl_paged_engine_get(engine, &info));
  const engine::PagedEngine twin = make_twin();
  EXPECT_EQ(info.width, kWidth);
  EXPECT_EQ(info.height, kHeight);
  EXPECT_EQ(info.items, twin.scene().items);
  EXPECT_EQ(info.pages, twin.scene().pages.size());
  EXPECT_EQ(info.bounds.max[0], twin.scene().fitted.bounds.max.x);
  EXPECT_GT(info.page_limit, 0u);
  sl_view view = SL_VIEW_INIT;
  ASSERT_OK(sl_view_fit(&info.bounds, nullptr, 0.8, double(kWidth) / kHeight, &view));
  sl_paged_report report = SL_PAGED_REPORT_INIT;
  std::int32_t arrived = 1;
  for (std::uint64_t frame = 0; frame < 1000; ++frame) {
    ASSERT_OK(sl_paged_engine_frame(engine, &view, &report));
    EXPECT_EQ(report.frame, frame);
    if (report.complete) break;
    EXPECT_GT(report.pending, 0);
    ASSERT_OK(sl_paged_engine_wait(engine, 1.0, &arrived));
  }
  EXPECT_EQ(report.complete, 1);
  EXPECT_GT(report.resident, 0u);
  ASSERT_OK(sl_paged_engine_wait(engine, HUGE_VAL, &arrived));
  EXPECT_EQ(arrived, 0) << "nothing is on its way";
  ASSERT_OK(sl_paged_engine_get(engine, &info));
  EXPECT_GT(info.page_bytes, 0u);
  char text[200];
  sl_text line = {text, sizeof text, 0};
  ASSERT_OK(sl_paged_engine_renderer(engine, &line));
  EXPECT_EQ(std::string(text), twin.renderer());
  for (const auto take : {sl_paged_engine_take_errors, sl_paged_engine_take_gl_errors}) {
    ASSERT_OK(take(engine, &line));
    EXPECT_EQ(line.length, 0u);
  }
}

TEST_F(CapiPaged, PagesThatCannotBeReadAreTold) {
  make_engine(config());
  const View view(make_twin().scene().fitted.bounds.centre(), 60.0);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 4);
  sl_paged_report report = SL_PAGED_REPORT_INIT;
  ASSERT_OK(sl_paged_engine_settle(engine, &view.c, nullptr, nullptr, &report));
  EXPECT_GT(report.failed, 0u);
  char text[4];
  sl_text line = {text, sizeof text, 0};
  ASSERT_OK(sl_paged_engine_take_errors(engine, &line));
  const std::size_t length = line.length;
  EXPECT_GT(length, sizeof text);
  std::vector<char> all(length + 1);
  line = {all.data(), all.size(), 0};
  ASSERT_OK(sl_paged_engine_take_errors(engine, &line));
  EXPECT_EQ(line.length, length) << "the first text had no room for it";
  ASSERT_OK(sl_paged_engine_take_errors(engine, &line));
  EXPECT_EQ(line.length, 0u);
}

struct Heard {
  sl_paged_engine engine = {0};
  const sl_view* view = nullptr;
  std::vector<double> shares;
  std::vector<sl_status> within;
};
std::int32_t stop(double share, void* user) {
  Heard& heard = *static_cast<Heard*>(user);
  heard.shares.push_back(share);
  if (heard.engine.id) {
    heard.within.push_back(sl_paged_engine_frame(heard.engine, heard.view, nullptr));
    heard.within.push_back(sl_paged_engine_destroy(heard.engine));
  }
  return 0;
}

TEST_F(CapiPaged, ProgressStopsAndMayNotUseTheEngine) {
  Heard heard;
  sl_paged_config with = config();
  with.progress = stop, with.progress_user = &heard;
  EXPECT_EQ(sl_paged_engine_create(file.c_str(), &with, &engine), SL_ERROR_CANCELLED);
  EXPECT_EQ(heard.shares.size(), 1u);
  EXPECT_EQ(engine.id, 0u);

  with = config();
  with.refine_ms = 0.0;
  make_engine(with);
  const View view(make_twin().scene().fitted.bounds.centre(), 60.0);
  heard = {engine, &view.c, {}, {}};
  sl_paged_report report = SL_PAGED_REPORT_INIT;
  ASSERT_OK(sl_paged_engine_settle(engine, &view.c, stop, &heard, &report));
  EXPECT_EQ(report.complete, 0);
  ASSERT_EQ(heard.shares.size(), 1u);
  EXPECT_GE(heard.shares[0], 0.0);
  EXPECT_LT(heard.shares[0], 1.0);
  EXPECT_EQ(heard.within, std::vector<sl_status>(2, SL_ERROR_BUSY));
  ASSERT_OK(sl_paged_engine_settle(engine, &view.c, nullptr, nullptr, &report));
  EXPECT_EQ(report.complete, 1);
}

TEST_F(CapiPaged, ThreadsWaitForEachOther) {
  make_engine(config());
  const core::dvec3 centre = make_twin().scene().fitted.bounds.centre();
  std::atomic<int> failed{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i)
    threads.emplace_back([&, i] {
      const View view(centre, 40.0 + 30.0 * i);
      for (int round = 0; round < 3; ++round)
        failed += sl_paged_engine_settle(engine, &view.c, nullptr, nullptr, nullptr) != SL_OK;
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(failed, 0);
}

TEST_F(CapiPaged, BadArgumentsAreErrors) {
  const sl_paged_config good = config();
  EXPECT_EQ(sl_paged_engine_create(nullptr, &good, &engine), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_paged_engine_create(file.c_str(), nullptr, &engine), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_paged_engine_create(file.c_str(), &good, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_paged_engine_create("no_such_file.slc", &good, &engine), SL_ERROR_FAILED);
  EXPECT_NE(std::string(sl_last_error()).find("no_such_file.slc"), std::string::npos) << sl_last_error();
  const auto refused = [&](const auto& change) {
    sl_paged_config with = config();
    change(with);
    return sl_paged_engine_create(file.c_str(), &with, &engine);
  };
  EXPECT_EQ(refused([](sl_paged_config& c) { c.memory_limit = 0; }), SL_ERROR_ARGUMENT);
  EXPECT_EQ(refused([](sl_paged_config& c) { c.width = 0; }), SL_ERROR_ARGUMENT);
  EXPECT_EQ(refused([](sl_paged_config& c) { c.refine_ms = std::nan(""); }), SL_ERROR_FAILED);
  EXPECT_EQ(refused([](sl_paged_config& c) { c.context.platform = 6; }), SL_ERROR_ARGUMENT);
  EXPECT_EQ(refused([](sl_paged_config& c) { c.losses.lod_error = -1.0; }), SL_ERROR_FAILED);
  EXPECT_EQ(refused([](sl_paged_config& c) { c.drawing.samples = 4; }), SL_ERROR_FAILED);
  EXPECT_NE(std::string(sl_last_error()).find("a paged engine has no samples"), std::string::npos) << sl_last_error();
  EXPECT_EQ(refused([](sl_paged_config& c) { c.memory_limit = 1; }), SL_ERROR_FAILED);
  EXPECT_NE(std::string(sl_last_error()).find("memory limit"), std::string::npos) << sl_last_error();
  EXPECT_EQ(engine.id, 0u);

  sl_paged_config without_ids = config();
  without_ids.drawing.ids = 0;
  make_engine(without_ids);
  std::vector<std::uint32_t> ids(std::size_t(kWidth) * kHeight);
  std::vector<float> metres(ids.size());
  EXPECT_EQ(sl_paged_engine_read_depth(engine, metres.data(), metres.size()), SL_ERROR_BUSY) << "no frame yet";
  sl_view nowhere = SL_VIEW_INIT;
  EXPECT_NE(sl_paged_engine_frame(engine, &nowhere, nullptr), SL_OK);
  const View view({}, 60.0);
  ASSERT_OK(sl_paged_engine_frame(engine, &view.c, nullptr));
  EXPECT_EQ(sl_paged_engine_read_ids(engine, ids.data(), ids.size()), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_paged_engine_read_depth(engine, nullptr, metres.size()), SL_ERROR_ARGUMENT);
  EXPECT_OK(sl_paged_engine_read_depth(engine, metres.data(), metres.size()));
  std::int32_t arrived = 0;
  EXPECT_EQ(sl_paged_engine_wait(engine, std::nan(""), &arrived), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_paged_engine_wait(engine, 0.0, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_paged_engine_get(engine, nullptr), SL_ERROR_ARGUMENT);
  const sl_paged_engine gone = engine;
  ASSERT_OK(sl_paged_engine_destroy(engine));
  engine = {0};
  for (const sl_paged_engine dead : {gone, engine, sl_paged_engine{std::uint64_t(3) << 60}}) {
    EXPECT_EQ(sl_paged_engine_frame(dead, &view.c, nullptr), SL_ERROR_HANDLE);
    EXPECT_EQ(sl_paged_engine_destroy(dead), SL_ERROR_HANDLE);
  }
}

TEST_F(CapiPaged, DefaultsAreThoseOfCpp) {
  compare_settings(sl_paged_config SL_PAGED_CONFIG_INIT, engine::PagedConfig());
}

TEST_F(CapiPaged, LooksAreThoseOfCpp) {
  sl_paged_config with = config();
  with.drawing.looks.lighting = SL_LIGHTING_STUDIO;
  with.drawing.looks.background.top[2] = 0.25f;
  with.drawing.looks.depth_shading.strength = 0.5f;
  make_engine(with);
  engine::PagedConfig cpp{.width = kWidth, .height = kHeight, .memory_limit = kMany};
  cpp.drawing.looks.lighting = gpuprims::Lighting::kStudio;
  cpp.drawing.looks.background.top.b = 0.25f;
  cpp.drawing.looks.depth_shading.strength = 0.5f;
  auto twin = engine::PagedEngine::create(std::move(*importers::open_paged_scene(file)), cpp);
  ASSERT_TRUE(twin) << twin.error().message;
  const View view(twin->scene().fitted.bounds.centre(), 60.0);
  ASSERT_OK(sl_paged_engine_settle(engine, &view.c, nullptr, nullptr, nullptr));
  ASSERT_TRUE(twin->settle(view.cpp));
  std::vector<std::uint8_t> pixels(std::size_t(kWidth) * kHeight * 3);
  ASSERT_OK(sl_paged_engine_read_colour(engine, pixels.data(), pixels.size()));
  EXPECT_EQ(pixels, twin->read_colour().pixels);
}

}  // namespace
}  // namespace sightline::tests::paged_test
