// Engines that draw: images in C are those of C++ to the bit, in contexts of their own and of the application's.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <random>

#include <glm/gtc/type_ptr.hpp>

#include "c_scene.h"
#include "random_calls.h"
#include "sightline/engine/engine.h"
#include "sightline/gl/external_target.h"
#include "sightline/render/image/image.h"
#include "sightline/tests/support/gl_test.h"
#include "sightline/tests/support/system_gl.h"

namespace sightline::tests::drawing_test {
namespace {

constexpr int kWidth = 160, kHeight = 120, kGrid = 6;

/// As an application in C finds GL's functions.
sl_proc find_proc(const char* name, void* user) {
  ++*static_cast<int*>(user);
  return foreign_proc(kSystemLibrary, name);
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
    made.draw = made.drawing.ids = 1;
    made.width = kWidth, made.height = kHeight;
    made.get_proc = find_proc, made.get_proc_user = &procs_asked;
    made.context.program_cache = "";
    return made;
  }
  sl_engine make_engine(const sl_engine_config& with) {
    sl_engine engine = {0};
    EXPECT_OK(sl_engine_create(c.scene, &with, &engine));
    return engine;
  }
  engine::EngineConfig twin_config() {
    engine::EngineConfig same;
    same.draw = same.drawing.ids = true;
    same.width = kWidth, same.height = kHeight;
    same.context.application = &*context;
    same.context.program_cache = "";
    return same;
  }
  engine::Engine make_twin() { return std::move(*engine::Engine::create(scene, twin_config())); }

  void expect_same_images(sl_engine engine, engine::Engine& twin) {
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
    EXPECT_EQ(report.items_drawn, expected->items_drawn);
    EXPECT_EQ(report.triangles, expected->triangles);
    EXPECT_EQ(report.coarseness, expected->coarseness);
    EXPECT_EQ(report.earlier, expected->earlier);
    expect_same_images(engine, twin);
    EXPECT_OK(sl_engine_finish(engine));
    EXPECT_OK(sl_engine_finish_levels(engine));
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
    gl::ExternalTarget same{of_twin.name(), 20, 10, kWidth - 20, kHeight - 10};
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

TEST_F(CapiDrawing, SeveralViewsLookAsInCpp) {
  engine::Engine twin = make_twin();
  const sl_engine engine = make_engine(config());
  const Framebuffer mine[2] = {Framebuffer(gl()), Framebuffer(gl())},
                    of_twin[2] = {Framebuffer(gl()), Framebuffer(gl())};
  sl_view other = view.c;
  other.eye_from_world[12] += 0.5;
  const core::View same_other = *core::View::from_matrices(glm::make_mat4(other.eye_from_world),
                                                           glm::make_mat4(other.clip_from_eye), view.cpp.clip_depth());
  sl_external_target into[2] = {SL_EXTERNAL_TARGET_INIT, SL_EXTERNAL_TARGET_INIT};
  std::vector<gl::ExternalTarget> same;
  for (int i = 0; i < 2; ++i) {
    into[i].framebuffer = mine[i].name();
    into[i].width = kWidth - 10 * i, into[i].height = kHeight;
    same.push_back({of_twin[i].name(), 0, 0, kWidth - 10 * i, kHeight});
  }
  const sl_view* views[2] = {&view.c, &other};
  const sl_external_target* targets[2] = {&into[0], &into[1]};
  sl_frame_report reports[2] = {SL_FRAME_REPORT_INIT, SL_FRAME_REPORT_INIT};
  sl_frame_report* told[2] = {&reports[0], &reports[1]};
  ASSERT_OK(sl_engine_frame_views(engine, views, targets, 2, told));
  ASSERT_TRUE(twin.frame(std::vector{view.cpp, same_other}, same));
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(reports[i].drawn, 1);
    EXPECT_EQ(mine[i].pixels(), of_twin[i].pixels());
    EXPECT_NE(mine[i].pixels(), Framebuffer(gl()).pixels()) << "nothing was drawn";
  }
  EXPECT_NE(mine[0].pixels(), mine[1].pixels());
  sl_engine_config now = SL_ENGINE_CONFIG_INIT;
  ASSERT_OK(sl_engine_use_image(engine, 1));
  ASSERT_OK(sl_engine_get_config(engine, &now));
  EXPECT_EQ(now.width, kWidth - 10);
  EXPECT_EQ(sl_engine_forget_image(engine, 1), SL_ERROR_FAILED) << "it is in use";
  EXPECT_OK(sl_engine_forget_image(engine, 0));
  targets[1] = nullptr;
  EXPECT_EQ(sl_engine_frame_views(engine, views, targets, 2, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_frame_views(engine, nullptr, targets, 1, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_OK(sl_engine_frame_views(engine, nullptr, nullptr, 0, nullptr));
  EXPECT_OK(sl_engine_destroy(engine));
}

TEST_F(CapiDrawing, OverridesLookAsInCpp) {
  engine::Engine twin = make_twin();
  const sl_engine engine = make_engine(config());
  const auto draw_both = [&] {
    ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, nullptr));
    ASSERT_TRUE(twin.frame(view.cpp));
    expect_same_images(engine, twin);
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
  ASSERT_TRUE(twin.set_override(cpp_ids(items), {.colour = core::vec3(1, 0, 0), .alpha = 0.5f}));
  draw_both();
  EXPECT_NE(twin.read_colour()->pixels, plain);
  ASSERT_OK(sl_engine_clear_override(engine, items.data(), 10));
  ASSERT_TRUE(twin.clear_override(cpp_ids(std::span(items).first(10))));
  draw_both();
  ASSERT_OK(sl_engine_clear_override(engine, nullptr, 0));
  ASSERT_TRUE(twin.clear_overrides());
  draw_both();
  EXPECT_EQ(twin.read_colour()->pixels, plain);
  EXPECT_OK(sl_engine_destroy(engine));
}

/// A setting in both APIs, with a name for messages.
struct Setting {
  const char* name;
  void (*c)(sl_engine_config&);
  void (*cpp)(engine::EngineConfig&);
  bool later = true;  // an engine that lives may change it
};

TEST_F(CapiDrawing, SettingsLookAsInCpp) {
  const Setting settings[] = {
      {"depth_shading",
       [](sl_engine_config& k) {
         k.drawing.looks.depth_shading.strength = 0.8f, k.drawing.looks.depth_shading.edge_lines = 0.6f;
       },
       [](engine::EngineConfig& k) {
         k.drawing.looks.depth_shading = {0.8f, 0.6f};
       }},
      {"shading alone", [](sl_engine_config& k) { k.drawing.looks.depth_shading.strength = 0.8f; },
       [](engine::EngineConfig& k) { k.drawing.looks.depth_shading.strength = 0.8f; }},
      {"hatching",
       [](sl_engine_config& k) { k.drawing.looks.hatching.strength = 0.9f, k.drawing.looks.hatching.spacing = 4.0f; },
       [](engine::EngineConfig& k) {
         k.drawing.looks.hatching = {0.9f, 4.0f};
       }},
      {"edges",
       [](sl_engine_config& k) {
         k.drawing.looks.edges = {SL_EDGES_FEATURE, 3.0f, {0.5f, 0.0f, 0.0f}};
       },
       [](engine::EngineConfig& k) {
         k.drawing.looks.edges = {engine::EdgeChoice::kFeature, 3.0f, {0.5f, 0.0f, 0.0f}};
       }},
      {"studio", [](sl_engine_config& k) { k.drawing.looks.lighting = SL_LIGHTING_STUDIO; },
       [](engine::EngineConfig& k) { k.drawing.looks.lighting = gpuprims::Lighting::kStudio; }},
      {"sun", [](sl_engine_config& k) { k.drawing.looks.lighting = SL_LIGHTING_SUN, k.drawing.looks.sun[0] = 2.0; },
       [](engine::EngineConfig& k) { k.drawing.looks.lighting = gpuprims::Lighting::kSun, k.drawing.looks.sun.x = 2.0; }},
      {"background",
       [](sl_engine_config& k) {
         k.drawing.looks.background.bottom[0] = 0.5f, k.drawing.looks.background.top[2] = 0.25f;
       },
       [](engine::EngineConfig& k) {
         k.drawing.looks.background.bottom.x = 0.5f, k.drawing.looks.background.top.z = 0.25f;
       }},
      {"outline colour", [](sl_engine_config& k) { k.drawing.outline_colour[2] = 1.0f; },
       [](engine::EngineConfig& k) { k.drawing.outline_colour.z = 1.0f; }},
      {"transparency", [](sl_engine_config& k) { k.drawing.transparency = SL_TRANSPARENCY_BLENDED; },
       [](engine::EngineConfig& k) { k.drawing.transparency = engine::Transparency::kBlended; }, false},
  };
  BothViews cut = view;
  cut.c.section_count = 1;
  cut.c.sections[0] = {{-1, 0.2, 0}, 5};
  cut.cpp.sections = {{{-1, 0.2, 0}, 5}};
  sl_item_style faded = SL_ITEM_STYLE_INIT;
  faded.alpha = 0.5f, faded.outline = 1;
  std::vector<sl_item> every_third;
  for (sl_item item = 0; item < kGrid * kGrid * kGrid; item += 3) every_third.push_back(item);
  const auto image = [&](sl_engine engine) {
    std::vector<std::uint8_t> rgb(std::size_t(3) * kWidth * kHeight);
    EXPECT_OK(sl_engine_set_override(engine, every_third.data(), every_third.size(), &faded));
    EXPECT_OK(sl_engine_frame(engine, &cut.c, nullptr, nullptr));
    EXPECT_OK(sl_engine_read_colour(engine, rgb.data(), rgb.size()));
    return rgb;
  };
  const sl_engine living = make_engine(config());
  const auto plain = image(living);
  for (const Setting& setting : settings) {
    SCOPED_TRACE(setting.name);
    sl_engine_config with = config();
    setting.c(with);
    engine::EngineConfig same = twin_config();
    setting.cpp(same);
    auto twin = engine::Engine::create(scene, same);
    ASSERT_TRUE(twin) << twin.error().message;
    const sl_engine engine = make_engine(with);
    const auto found = image(engine);
    ASSERT_TRUE(twin->set_override(cpp_ids(every_third), {.alpha = 0.5f, .outline = true}) && twin->frame(cut.cpp));
    EXPECT_EQ(found, twin->read_colour()->pixels);
    EXPECT_NE(found, plain);
    EXPECT_OK(sl_engine_destroy(engine));
    sl_engine_config now = SL_ENGINE_CONFIG_INIT;
    ASSERT_OK(sl_engine_get_config(living, &now));
    setting.c(now);
    ASSERT_EQ(sl_engine_configure(living, &now), setting.later ? SL_OK : SL_ERROR_FAILED);
    EXPECT_EQ(image(living), setting.later ? found : plain);
    if (!setting.later) continue;
    sl_engine_config back = config();
    ASSERT_OK(sl_engine_configure(living, &back));
    EXPECT_EQ(image(living), plain) << "nothing is left of it";
  }
  EXPECT_OK(sl_engine_destroy(living));
}

TEST_F(CapiDrawing, OutlinesAreDrawnOverAFramebuffer) {
  engine::Engine twin = make_twin();
  const sl_engine engine = make_engine(config());
  const Framebuffer mine(gl()), of_twin(gl());
  sl_external_target target = SL_EXTERNAL_TARGET_INIT;
  target.framebuffer = mine.name();
  target.width = kWidth, target.height = kHeight;
  gl::ExternalTarget same{of_twin.name(), 0, 0, kWidth, kHeight};
  ASSERT_OK(sl_engine_frame_into(engine, &view.c, &target, nullptr));
  ASSERT_TRUE(twin.frame(view.cpp, same));
  const auto before = mine.pixels();
  const std::vector<sl_item> items = {0, 7, 43}, unknown = {100'000};
  ASSERT_OK(sl_engine_draw_outline(engine, &view.c, items.data(), items.size(), &target));
  ASSERT_TRUE(twin.draw_outline(view.cpp, cpp_ids(items), same));
  EXPECT_EQ(mine.pixels(), of_twin.pixels());
  EXPECT_NE(mine.pixels(), before) << "there is a line";
  EXPECT_EQ(sl_engine_draw_outline(engine, &view.c, unknown.data(), 1, &target), SL_ERROR_FAILED);
  EXPECT_EQ(sl_engine_draw_outline(engine, &view.c, nullptr, 1, &target), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_draw_outline(engine, &view.c, items.data(), 1, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_EQ(mine.pixels(), of_twin.pixels());
  EXPECT_OK(sl_engine_destroy(engine));
}

TEST_F(CapiDrawing, TilesAreTheWholeImage) {
  constexpr int kWide = 200, kHigh = 150;
  const BothViews whole({5, -14, 9}, {5, 5, 5}, double(kWide) / kHigh);
  sl_engine_config with = config();
  with.width = kWide, with.height = kHigh;
  const sl_engine engine = make_engine(with);
  std::vector<std::uint32_t> expected(std::size_t(kWide) * kHigh), found(expected.size(), 77'777);
  ASSERT_OK(sl_engine_frame(engine, &whole.c, nullptr, nullptr));
  ASSERT_OK(sl_engine_read_ids(engine, expected.data(), expected.size()));
  std::int32_t width = 0, height = 0;
  sl_cropped_tile tiles[64];
  std::size_t count = 0;
  ASSERT_OK(sl_image_tiles(kWide, kHigh, 96, 0, &width, &height, tiles, 64, &count));
  EXPECT_GE(count, 4u);
  ASSERT_OK(sl_engine_resize(engine, width, height));
  for (std::size_t i = 0; i < count; ++i) {
    const sl_cropped_tile& tile = tiles[i];
    sl_frame_report report = SL_FRAME_REPORT_INIT;
    ASSERT_OK(sl_engine_frame_tile(engine, &whole.c, &tile.tile, &report));
    EXPECT_EQ(report.drawn, 1);
    std::vector<std::uint32_t> ids(std::size_t(width) * std::size_t(height));
    ASSERT_OK(sl_engine_read_ids(engine, ids.data(), ids.size()));
    for (int y = tile.y0; y < tile.y1; ++y)
      for (int x = tile.x0; x < tile.x1; ++x)
        found[std::size_t(y * kWide + x)] = ids[std::size_t((y - int(tile.tile.y)) * width + x - int(tile.tile.x))];
  }
  int other = 0;
  for (std::size_t i = 0; i < found.size(); ++i) other += found[i] != expected[i];
  EXPECT_LE(other, int(found.size() / 200)) << "but for rounding at edges";
  EXPECT_EQ(std::count(found.begin(), found.end(), 77'777u), 0);
  EXPECT_OK(sl_engine_destroy(engine));
}

TEST_F(CapiDrawing, LossIsThatOfCpp) {
  sl_engine_config with = config();
  with.losses.min_projected_area = 40.0f;
  engine::EngineConfig same = twin_config();
  same.losses.min_projected_area = 40.0f;
  auto twin = engine::Engine::create(scene, same);
  ASSERT_TRUE(twin && twin->frame(view.cpp));
  const auto expected = twin->loss(view.cpp);
  ASSERT_TRUE(expected);
  const sl_engine engine = make_engine(with);
  ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, nullptr));
  sl_loss_report loss = SL_LOSS_REPORT_INIT;
  ASSERT_OK(sl_engine_loss(engine, &view.c, &loss));
  EXPECT_EQ(loss.items, expected->items);
  EXPECT_EQ(loss.pixels, expected->pixels);
  EXPECT_EQ(loss.lod_error, expected->lod_error);
  EXPECT_EQ(loss.triangles, expected->triangles);
  EXPECT_EQ(loss.full_triangles, expected->full_triangles);
  EXPECT_EQ(loss.coarseness, expected->coarseness);
  EXPECT_EQ(loss.coarser_share, expected->coarser_share);
  EXPECT_GT(loss.items, 5);
  sl_engine_config now = SL_ENGINE_CONFIG_INIT;
  ASSERT_OK(sl_engine_get_config(engine, &now));
  now.losses.min_projected_area = 0.0f;
  ASSERT_OK(sl_engine_configure(engine, &now));
  ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, nullptr));
  ASSERT_OK(sl_engine_loss(engine, &view.c, &loss));
  EXPECT_EQ(loss.items, 0);
  EXPECT_EQ(sl_engine_loss(engine, &view.c, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_OK(sl_engine_destroy(engine));
}

TEST_F(CapiDrawing, CullStatesKnowWhatIsOccluded) {
  const sl_engine engine = make_engine(config());
  engine::Engine twin = make_twin();
  const BothViews near({5, -3, 5}, {5, 5, 5}, double(kWidth) / kHeight);
  sl_cull_states states = SL_CULL_STATES_INIT;
  ASSERT_OK(sl_engine_cull_states(engine, &near.c, &states));
  const auto expected = twin.cull_states(near.cpp);
  ASSERT_TRUE(expected);
  EXPECT_TRUE(std::equal(expected->items.begin(), expected->items.end(), states.items));
  EXPECT_OK(sl_engine_destroy(engine));
}

TEST_F(CapiDrawing, TheImageIsInAFramebuffer) {
  const sl_engine engine = make_engine(config());
  std::int32_t covered = 7;
  std::uint32_t name = 0;
  EXPECT_EQ(sl_engine_covered(engine, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_framebuffer(engine, nullptr), SL_ERROR_ARGUMENT);
  const BothViews nothing({5, -14, 9}, {5, -30, 9});
  ASSERT_OK(sl_engine_frame(engine, &nothing.c, nullptr, nullptr));
  ASSERT_OK(sl_engine_covered(engine, &covered));
  EXPECT_EQ(covered, 0);
  ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, nullptr));
  ASSERT_OK(sl_engine_covered(engine, &covered));
  EXPECT_EQ(covered, 1);
  ASSERT_OK(sl_engine_framebuffer(engine, &name));
  ASSERT_NE(name, 0u);
  std::vector<std::uint8_t> rgb(std::size_t(3) * kWidth * kHeight), there(rgb.size());
  ASSERT_OK(sl_engine_read_colour(engine, rgb.data(), rgb.size()));
  gl().BindFramebuffer(GL_READ_FRAMEBUFFER, name);
  gl().PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl().ReadPixels(0, 0, kWidth, kHeight, GL_RGB, GL_UNSIGNED_BYTE, there.data());
  for (int y = 0; y < kHeight; ++y) {
    const auto row = [&](std::vector<std::uint8_t>& of, int at) { return of.begin() + 3 * kWidth * at; };
    EXPECT_TRUE(std::equal(row(rgb, y), row(rgb, y + 1), row(there, kHeight - 1 - y))) << y;
  }
  char lines[512];
  sl_text text = {lines, sizeof lines, 0};
  ASSERT_OK(sl_engine_renderer(engine, &text));
  EXPECT_EQ(std::string(lines), context->renderer());
  ASSERT_OK(sl_engine_drop_context(engine));
  EXPECT_EQ(sl_engine_framebuffer(engine, &name), SL_ERROR_FAILED);
  EXPECT_EQ(sl_engine_covered(engine, &covered), SL_ERROR_FAILED);
  ASSERT_OK(sl_engine_renderer(engine, &text));
  EXPECT_STREQ(lines, "");
  EXPECT_OK(sl_engine_destroy(engine));
}

TEST_F(CapiDrawing, ErrorsOfGlAreToldOnce) {
  sl_engine_config with = config();
  with.context.gl_state = SL_GL_STATE_LEAVE;
  const sl_engine engine = make_engine(with);
  ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, nullptr));
  char lines[512];
  sl_text text = {lines, sizeof lines, 0};
  ASSERT_OK(sl_engine_take_gl_errors(engine, &text));
  EXPECT_STREQ(lines, "");
  gl().Enable(0xdead);
  text.capacity = 3;
  ASSERT_OK(sl_engine_take_gl_errors(engine, &text));
  const std::size_t length = text.length;
  EXPECT_GT(length, 3u);
  text.capacity = sizeof lines;
  ASSERT_OK(sl_engine_take_gl_errors(engine, &text));
  EXPECT_EQ(std::string(lines).size(), length) << "it had not fitted";
  EXPECT_EQ(lines[length - 1], '\n');
  ASSERT_OK(sl_engine_take_gl_errors(engine, &text));
  EXPECT_EQ(text.length, 0u);
  EXPECT_EQ(context->take_errors().size(), 1u) << "this one, for the test's own log";
  EXPECT_OK(sl_engine_destroy(engine));
}

TEST_F(CapiDrawing, AContextIsTakenInPortions) {
  engine::Engine twin = make_twin();
  ASSERT_TRUE(twin.frame(view.cpp));
  sl_engine_config with = config();
  with.context.later = 1;
  sl_engine engine = {0};
  EXPECT_EQ(sl_engine_create(c.scene, &with, &engine), SL_ERROR_FAILED) << "there is one";
  with.get_proc = nullptr;
  engine = make_engine(with);
  sl_frame_report report = SL_FRAME_REPORT_INIT;
  std::int32_t complete = 7;
  EXPECT_EQ(sl_engine_use_context_for(engine, nullptr, nullptr, 0.0, &complete), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_use_context_for(engine, find_nothing, nullptr, 0.0, &complete), SL_ERROR_FAILED);
  EXPECT_EQ(sl_engine_use_context_for(engine, find_proc, &procs_asked, std::nan(""), &complete), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_engine_use_context_for(engine, find_proc, &procs_asked, 0.0, nullptr), SL_ERROR_ARGUMENT);
  EXPECT_EQ(complete, 7);
  int portions = 0;
  const auto take = [&](int most) {
    for (complete = 0; !complete && portions < most; ++portions) {
      ASSERT_OK(sl_engine_use_context_for(engine, portions == 0 ? find_proc : nullptr, &procs_asked, 0.0, &complete));
      ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, &report));
      EXPECT_EQ(report.drawn, complete);
    }
  };
  take(3);
  EXPECT_EQ(complete, 0) << "it takes more than three steps";
  ASSERT_OK(sl_engine_drop_context(engine));
  portions = 0;
  take(100'000);
  EXPECT_EQ(complete, 1);
  EXPECT_GT(portions, 3);
  expect_same_images(engine, twin);
  EXPECT_EQ(sl_engine_use_context_for(engine, find_proc, &procs_asked, 0.0, &complete), SL_ERROR_BUSY);
  ASSERT_OK(sl_engine_abandon_context(engine));
  ASSERT_OK(sl_engine_use_context_for(engine, find_proc, &procs_asked, HUGE_VAL, &complete));
  EXPECT_EQ(complete, 1);
  ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, nullptr));
  expect_same_images(engine, twin);
  ASSERT_OK(sl_engine_drop_context(engine));
  ASSERT_OK(sl_engine_use_context_for(engine, find_proc, &procs_asked, 0.0, &complete));
  EXPECT_EQ(complete, 0);
  EXPECT_OK(sl_engine_destroy(engine)) << "while it is coming";
}

TEST_F(CapiDrawing, HybridsAreTold) {
  fill_grid(c, scene, 22);  // a hybrid is made from ten thousand items on
  for (const std::int32_t variant : {SL_GPU_VARIANT_GEOMETRY, SL_GPU_VARIANT_COMPUTE}) {
    sl_engine_config with = config();
    with.culling.culler = SL_CULLER_HYBRID;
    with.culling.gpu_variant = variant;
    with.losses.budget_ms = 0.0;
    const sl_engine engine = make_engine(with);
    sl_controller_info info = SL_CONTROLLER_INFO_INIT;
    sl_frame_report report = SL_FRAME_REPORT_INIT;
    std::uint64_t probes = 0;
    for (std::uint64_t frame = 1; frame <= 8; ++frame) {
      ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, &report));
      ASSERT_OK(sl_engine_get_controller(engine, &info));
      EXPECT_EQ(info.there, 1);
      EXPECT_EQ(info.frames, frame);
      EXPECT_EQ(info.state, report.hybrid_state);
      EXPECT_EQ(info.probes > probes, info.state == std::int32_t(culling::ControllerState::kProbe));
      probes = info.probes;
    }
    EXPECT_GT(probes, 0u) << "the other path is measured";
    char lines[8192];
    sl_text text = {lines, sizeof lines, 0};
    ASSERT_OK(sl_engine_explain(engine, &text));
    const char* name = variant == SL_GPU_VARIANT_GEOMETRY ? "geometry" : "compute";
    EXPECT_NE(std::string(lines).find(name), std::string::npos) << lines;
    EXPECT_OK(sl_engine_destroy(engine));
  }
}

TEST_F(CapiDrawing, CreationWithAContextMayBeCancelled) {
  sl_engine_config with = config();
  with.progress = [](double, void*) -> std::int32_t { return 0; };
  sl_engine engine = {5};
  EXPECT_EQ(sl_engine_create(c.scene, &with, &engine), SL_ERROR_CANCELLED);
  EXPECT_EQ(engine.id, 5u);
  engine = make_engine(config());
  ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, nullptr));
  EXPECT_OK(sl_engine_destroy(engine));
}

TEST_F(CapiDrawing, ImagesNeedRoom) {
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
  const auto jpeg = std::filesystem::path(::testing::TempDir()) / "capi.jpg";
  EXPECT_EQ(sl_write_png(jpeg.string().c_str(), 2, 2, rgb), SL_ERROR_FAILED) << "PNG under another name";
  EXPECT_FALSE(std::filesystem::exists(jpeg));
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
    expect_same_images(engine, twin);
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
