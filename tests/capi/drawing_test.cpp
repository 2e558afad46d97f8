// Engines that draw: pictures in C are those of C++ to the bit, in contexts of their own and of the application's.
#include <cstdio>
#include <filesystem>
#include <random>

#include <dlfcn.h>

#include "c_scene.h"
#include "random_calls.h"
#include "sightline/engine/engine.h"
#include "sightline/image/image.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests::drawing_test {
namespace {

constexpr int kWidth = 160, kHeight = 120, kGrid = 6;

/// As an application in C finds GL's functions.
sl_proc find_proc(const char* name, void* user) {
  ++*static_cast<int*>(user);
  static void* const egl = dlopen("libEGL.so.1", RTLD_NOW);
  using Find = sl_proc (*)(const char*);
  static const auto find = reinterpret_cast<Find>(dlsym(egl, "eglGetProcAddress"));
  return find(name);
}

sl_proc find_nothing(const char*, void*) {
  return nullptr;
}

/// A test has the context of an application, current.
class CapiDrawing : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    fill_grid(c, scene, kGrid);
  }

  sl_engine_config config() {
    sl_engine_config made = SL_ENGINE_CONFIG_INIT;
    made.draw = made.ids = 1;
    made.width = kWidth, made.height = kHeight;
    made.get_proc = find_proc, made.get_proc_user = &procs_asked;
    made.program_cache = "";
    return made;
  }
  sl_engine make_engine(const sl_engine_config& with) {
    sl_engine engine = {0};
    EXPECT_OK(sl_engine_create(c.scene, &with, &engine));
    return engine;
  }
  engine::Engine make_twin() {
    engine::EngineConfig same;
    same.draw = same.ids = true;
    same.width = kWidth, same.height = kHeight;
    same.context = &*context;
    same.program_cache = "";
    return std::move(*engine::Engine::create(scene, same));
  }

  void expect_same_pictures(sl_engine engine, engine::Engine& twin) {
    const auto pixels = std::size_t(kWidth) * kHeight;
    std::vector<std::uint8_t> rgb(3 * pixels);
    std::vector<std::uint32_t> ids(pixels);
    std::vector<float> metres(pixels);
    ASSERT_OK(sl_engine_read_colour(engine, rgb.data(), rgb.size()));
    ASSERT_OK(sl_engine_read_ids(engine, ids.data(), ids.size()));
    ASSERT_OK(sl_engine_read_depth(engine, &view.c, metres.data(), metres.size()));
    ASSERT_TRUE(context->make_current());
    EXPECT_EQ(rgb, twin.read_colour()->pixels);
    EXPECT_EQ(ids, twin.read_ids()->ids);
    EXPECT_EQ(metres, twin.read_depth(view.cpp)->metres);
    EXPECT_TRUE(*twin.covered());
  }

  CScene c;
  core::Scene scene;
  const BothViews view{{5, -14, 9}, {5, 5, 5}, double(kWidth) / kHeight};
  int procs_asked = 0;
};

TEST_F(CapiDrawing, DrawsWhatCppDraws) {
  engine::Engine twin = make_twin();
  const auto expected = twin.frame(view.cpp);
  ASSERT_TRUE(expected);
  for (const bool own_context : {false, true}) {
    sl_engine_config with = config();
    if (own_context) with.get_proc = nullptr;
    const sl_engine engine = make_engine(with);
    sl_frame_report report = SL_FRAME_REPORT_INIT;
    ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, &report));
    EXPECT_EQ(report.drawn, 1);
    EXPECT_EQ(report.visible, expected->visible);
    EXPECT_EQ(report.shown, expected->shown);
    expect_same_pictures(engine, twin);
    EXPECT_OK(sl_engine_finish(engine));
    EXPECT_OK(sl_engine_destroy(engine));
    ASSERT_TRUE(context->make_current());
  }
  EXPECT_GT(procs_asked, 100);
}

/// A framebuffer of the application's, filled with one colour.
class Framebuffer {
 public:
  explicit Framebuffer(const gl::Functions& gl) : gl_(gl) {
    gl.CreateRenderbuffers(1, &colour_);
    gl.CreateRenderbuffers(1, &depth_);
    gl.NamedRenderbufferStorage(colour_, GL_RGBA8, kWidth, kHeight);
    gl.NamedRenderbufferStorage(depth_, GL_DEPTH_COMPONENT24, kWidth, kHeight);
    gl.CreateFramebuffers(1, &name_);
    gl.NamedFramebufferRenderbuffer(name_, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_);
    gl.NamedFramebufferRenderbuffer(name_, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
    const float red[4] = {1, 0, 0, 1}, far = 1.0f;
    gl.ClearNamedFramebufferfv(name_, GL_COLOR, 0, red);
    gl.ClearNamedFramebufferfv(name_, GL_DEPTH, 0, &far);
  }
  ~Framebuffer() {
    gl_.DeleteFramebuffers(1, &name_);
    gl_.DeleteRenderbuffers(1, &colour_);
    gl_.DeleteRenderbuffers(1, &depth_);
  }
  Framebuffer(const Framebuffer&) = delete;
  Framebuffer& operator=(const Framebuffer&) = delete;

  GLuint name() const { return name_; }
  std::vector<std::uint8_t> pixels() const {
    std::vector<std::uint8_t> rgba(4 * kWidth * kHeight);
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, name_);
    gl_.ReadPixels(0, 0, kWidth, kHeight, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
    return rgba;
  }

 private:
  const gl::Functions& gl_;
  GLuint name_ = 0, colour_ = 0, depth_ = 0;
};

TEST_F(CapiDrawing, DrawsIntoTheApplicationsFramebuffer) {
  engine::Engine twin = make_twin();
  const sl_engine engine = make_engine(config());
  for (const bool clear : {false, true}) {
    const Framebuffer mine(gl()), of_twin(gl());
    sl_external_target target = SL_EXTERNAL_TARGET_INIT;
    target.framebuffer = mine.name();
    target.x = 20, target.y = 10, target.width = kWidth - 20, target.height = kHeight - 10;
    target.clear_colour = target.clear_depth = clear;
    sl_frame_report report = SL_FRAME_REPORT_INIT;
    ASSERT_OK(sl_engine_frame_into(engine, &view.c, &target, &report));
    EXPECT_EQ(report.drawn, 1);
    core::ExternalTarget same{of_twin.name(), 20, 10, kWidth - 20, kHeight - 10};
    same.clear_colour = same.clear_depth = clear;
    ASSERT_TRUE(twin.frame(view.cpp, same));
    EXPECT_EQ(mine.pixels(), of_twin.pixels());
    EXPECT_NE(mine.pixels(), Framebuffer(gl()).pixels()) << "nothing was drawn";
  }
  sl_external_target bad = SL_EXTERNAL_TARGET_INIT;
  EXPECT_EQ(sl_engine_frame_into(engine, &view.c, &bad, nullptr), SL_ERROR_ARGUMENT) << "no size";
  bad.width = bad.height = 10;
  bad.far_depth = bad.near_depth;
  EXPECT_EQ(sl_engine_frame_into(engine, &view.c, &bad, nullptr), SL_ERROR_FAILED);
  EXPECT_EQ(sl_engine_frame_into(engine, &view.c, nullptr, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_OK(sl_engine_destroy(engine));
}

TEST_F(CapiDrawing, OverridesLookAsInCpp) {
  engine::Engine twin = make_twin();
  const sl_engine engine = make_engine(config());
  const auto draw_both = [&] {
    ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, nullptr));
    ASSERT_TRUE(twin.frame(view.cpp));
    expect_same_pictures(engine, twin);
  };
  std::vector<sl_item> items;
  for (sl_item item = 0; item < 100; item += 2) items.push_back(item);
  draw_both();
  const auto plain = twin.read_colour()->pixels;
  sl_item_style style = SL_ITEM_STYLE_INIT;
  style.use_colour = 1;
  style.colour[0] = 1;
  style.alpha = 0.5f;
  ASSERT_OK(sl_engine_set_override(engine, items.data(), items.size(), &style));
  ASSERT_TRUE(twin.set_override(items, {.colour = core::vec3(1, 0, 0), .alpha = 0.5f}));
  draw_both();
  EXPECT_NE(twin.read_colour()->pixels, plain);
  ASSERT_OK(sl_engine_clear_override(engine, items.data(), 10));
  ASSERT_TRUE(twin.clear_override(std::span(items).first(10)));
  draw_both();
  ASSERT_OK(sl_engine_clear_override(engine, nullptr, 0));
  ASSERT_TRUE(twin.clear_overrides());
  draw_both();
  EXPECT_EQ(twin.read_colour()->pixels, plain);
  EXPECT_OK(sl_engine_destroy(engine));
}

TEST_F(CapiDrawing, PicturesNeedRoom) {
  const sl_engine engine = make_engine(config());
  ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, nullptr));
  std::vector<std::uint8_t> rgb(3 * kWidth * kHeight - 1, 7);
  EXPECT_EQ(sl_engine_read_colour(engine, rgb.data(), rgb.size()), SL_ERROR_ARGUMENT);
  EXPECT_EQ(rgb[0], 7);
  EXPECT_EQ(sl_engine_read_colour(engine, nullptr, 1'000'000), SL_ERROR_ARGUMENT);
  ASSERT_OK(sl_engine_resize(engine, 32, 16));
  ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, nullptr));
  EXPECT_OK(sl_engine_read_colour(engine, rgb.data(), 3 * 32 * 16));
  EXPECT_OK(sl_engine_destroy(engine));
}

TEST_F(CapiDrawing, SavesPng) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "capi.png";
  const std::uint8_t rgb[12] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  ASSERT_OK(sl_write_png(file.string().c_str(), 2, 2, rgb));
  const auto read = image::read_png(file);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->width, 2);
  EXPECT_TRUE(std::equal(rgb, rgb + 12, read->pixels.begin()));
  std::filesystem::remove(file);
  EXPECT_EQ(sl_write_png("/no/such/folder/a.png", 2, 2, rgb), SL_ERROR_FAILED);
  EXPECT_EQ(sl_write_png(nullptr, 2, 2, rgb), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_write_png("a.png", 0, 2, rgb), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_write_png("a.png", 2, 2, nullptr), SL_ERROR_ARGUMENT);
}

TEST_F(CapiDrawing, ContextsAreDroppedAbandonedAndReplaced) {
  engine::Engine twin = make_twin();
  ASSERT_TRUE(twin.frame(view.cpp));
  const sl_engine engine = make_engine(config());
  sl_frame_report report = SL_FRAME_REPORT_INIT;
  EXPECT_EQ(sl_engine_use_context(engine, find_proc, &procs_asked), SL_ERROR_BUSY);
  for (const bool gone : {false, true, false}) {
    ASSERT_OK(gone ? sl_engine_abandon_context(engine) : sl_engine_drop_context(engine));
    ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, &report));
    EXPECT_EQ(report.drawn, 0);
    EXPECT_GT(report.visible, 10);
    EXPECT_NE(sl_engine_read_colour(engine, nullptr, 0), SL_OK);
    EXPECT_EQ(sl_engine_use_context(engine, nullptr, nullptr), SL_ERROR_ARGUMENT);
    EXPECT_EQ(sl_engine_use_context(engine, find_nothing, nullptr), SL_ERROR_FAILED);
    ASSERT_OK(sl_engine_use_context(engine, find_proc, &procs_asked));
    ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, &report));
    EXPECT_EQ(report.drawn, 1);
    expect_same_pictures(engine, twin);
  }
  EXPECT_OK(sl_engine_destroy(engine));
}

TEST_F(CapiDrawing, AnAbandonedContextMayBeGone) {
  auto dying = gl::Context::create_offscreen();
  ASSERT_TRUE(dying);
  const sl_engine engine = make_engine(config());
  ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, nullptr));
  dying = core::fail("destroyed");
  ASSERT_OK(sl_engine_abandon_context(engine));
  EXPECT_OK(sl_engine_destroy(engine));
  ASSERT_TRUE(context->make_current());
}

TEST_F(CapiDrawing, AContextWithoutFunctionsIsAnError) {
  sl_engine_config with = config();
  with.get_proc = find_nothing;
  sl_engine engine = {3};
  EXPECT_EQ(sl_engine_create(c.scene, &with, &engine), SL_ERROR_FAILED);
  EXPECT_EQ(engine.id, 3u);
  EXPECT_NE(*sl_last_error(), '\0');
}

TEST_F(CapiDrawing, RandomCallsKeepTheirPromises) {
  for (unsigned seed = 1; seed <= 16; ++seed) {
    std::printf("seed %u\n", seed);  // for what ends the process
    std::fflush(stdout);
    std::mt19937 random(seed);
    std::vector<std::uint8_t> bytes(8000);
    for (std::uint8_t& byte : bytes) byte = std::uint8_t(random());
    ASSERT_EQ(make_random_calls(bytes.data(), bytes.size(), true), "") << "seed " << seed;
  }
  ASSERT_TRUE(context->make_current());
}

}  // namespace
}  // namespace sightline::tests::drawing_test
