// Images in framebuffers of an application's.
#include "sightline/gl/external_target.h"

#include <gtest/gtest.h>

#include "sightline/culling/queries/region_query.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/tests/engine/application.h"
#include "sightline/tests/engine/drawn_grid.h"

namespace sightline::tests::external_target_test {
namespace {

using engine::CullerChoice;
using engine::Engine;

constexpr int kWidth = 96, kHeight = 64;
constexpr std::array<core::dvec3, 4> kWall{{{-900, 11, -900}, {900, 11, -900}, {900, 11, 900}, {-900, 11, 900}}};
const core::vec3 kWallColour{1.0f, 0.6f, 0.0f};

class ExternalTarget : public DrawnGrid {
 protected:
  /// The grid of fill(scene, 22), from aside.
  static core::View perspective() {
    return *core::View::perspective({{-9, -4, 20}, {11, 11, 11}, {0, 0, 1}}, 0.8, double(kWidth) / kHeight, 0.5, 90.0);
  }
  static core::View orthographic() {
    return *core::View::orthographic({{-9, -4, 20}, {11, 11, 11}, {0, 0, 1}}, 24.0, double(kWidth) / kHeight, -5.0,
                                     70.0);
  }
  Engine engine(const engine::EngineConfig& c) {
    auto made = Engine::create(scene, c);
    EXPECT_TRUE(made) << made.error().message;
    return std::move(*made);
  }
  Engine engine(CullerChoice culler = CullerChoice::kCpu) { return engine(config(culler, kWidth, kHeight)); }

  static void expect_frame(Engine& engine, const core::View& view, const gl::ExternalTarget& target) {
    const auto report = engine.frame(view, target);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->drawn);
  }

  /// Row y, column x of an application's pixels, from below.
  static std::array<int, 3> pixel(const std::vector<std::uint8_t>& rgba, int x, int y, int width = kWidth) {
    const std::size_t at = 4 * std::size_t(y * width + x);
    return {rgba[at], rgba[at + 1], rgba[at + 2]};
  }
  static std::array<int, 3> pixel(const image::Image& image, int x, int y) {
    const std::size_t at = 3 * std::size_t((image.height - 1 - y) * image.width + x);
    return {image.pixels[at], image.pixels[at + 1], image.pixels[at + 2]};
  }
  /// Distance along the axis of the view to the plane y = 11, through a pixel's centre; infinite beyond the planes.
  static double wall_distance(const core::View& view, int x, int y) {
    const core::dmat4 world_from_clip = glm::inverse(view.clip_from_world());
    const auto point = [&](double depth) {
      const core::dvec4 p =
          world_from_clip * core::dvec4(2.0 * (x + 0.5) / kWidth - 1.0, 2.0 * (y + 0.5) / kHeight - 1.0, depth, 1.0);
      return core::dvec3(p) / p.w;
    };
    const core::dvec3 near = point(1.0), far = point(0.0);
    const double t = (11.0 - near.y) / (far.y - near.y);
    if (t < 0.0 || t > 1.0) return std::numeric_limits<double>::infinity();
    return -(view.eye_from_world() * core::dvec4(near + t * (far - near), 1.0)).z;
  }

  core::Scene scene;
};

TEST_F(ExternalTarget, AClearedOneHoldsTheEnginesImage) {
  fill(scene, 22);
  for (const CullerChoice culler : {CullerChoice::kCpu, CullerChoice::kGpu}) {
    for (const DepthMode& mode : kDepthModes) {
      SCOPED_TRACE(mode.name);
      const Application application(gl(), kWidth, kHeight, mode);
      Engine drawn = engine(culler);
      gl::ExternalTarget target = application.target();
      target.clear_colour = target.clear_depth = true;
      expect_frame(drawn, perspective(), target);
      const auto rgba = application.pixels();
      const image::Image own = *drawn.read_colour();
      const image::DepthImage metres = *drawn.read_depth(perspective());
      const auto depths = application.depths();
      int covered = 0;
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          ASSERT_EQ(pixel(rgba, x, y), pixel(own, x, y)) << x << ", " << y;
          const double distance = metres.metres[std::size_t((kHeight - 1 - y) * kWidth + x)];
          const double reversed = std::isinf(distance) ? 0.0 : 0.5 * (90.0 - distance) / (distance * 89.5);
          const double expected = mode.far_depth + (mode.near_depth - mode.far_depth) * reversed;
          ASSERT_NEAR(depths[std::size_t(y * kWidth + x)], expected, 0x1p-22) << x << ", " << y;
          covered += !std::isinf(distance);
        }
      EXPECT_GT(covered, 2000);
      EXPECT_LT(covered, kWidth * kHeight);
    }
  }
}

TEST_F(ExternalTarget, HidesAndIsHiddenByWhatTheApplicationDrawsBeforeAndAfter) {
  fill(scene, 22);
  for (const core::View& view : {perspective(), orthographic()}) {
    for (const DepthMode& mode : kDepthModes) {
      SCOPED_TRACE(testing::Message() << mode.name << (view.orthographic() ? ", orthographic" : ", perspective"));
      const Application application(gl(), kWidth, kHeight, mode);
      Engine drawn = engine();
      application.clear();
      application.draw(view, kWall, kWallColour);
      expect_frame(drawn, view, application.target());
      const auto wall_first = application.pixels();
      application.clear();
      expect_frame(drawn, view, application.target());
      application.draw(view, kWall, kWallColour);
      const auto wall_last = application.pixels();

      const image::Image own = *drawn.read_colour();
      const image::DepthImage metres = *drawn.read_depth(view);
      int ties = 0, walls = 0, items = 0;
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const double item = metres.metres[std::size_t((kHeight - 1 - y) * kWidth + x)];
          const double wall = wall_distance(view, x, y);
          if (std::abs(item - wall) < 2e-3) {
            ++ties;
            continue;
          }
          std::array<int, 3> expected = std::array<int, 3>{51, 102, 153};  // kSky
          if (item < wall) {
            expected = pixel(own, x, y), ++items;
          } else if (wall < item) {
            expected = {255, 153, 0}, ++walls;
          }
          ASSERT_EQ(pixel(wall_first, x, y), expected) << x << ", " << y << ": " << item << " m, wall " << wall << " m";
          ASSERT_EQ(pixel(wall_last, x, y), expected) << x << ", " << y << ": " << item << " m, wall " << wall << " m";
        }
      EXPECT_GT(items, 800);
      EXPECT_GT(walls, 800);
      EXPECT_LT(ties, 10);
    }
  }
}

TEST_F(ExternalTarget, NothingOutsideThePartIsTouched) {
  fill(scene, 22);
  Application application(gl(), 2 * kWidth, 2 * kHeight, kDepthModes[5]);
  const auto other = *gl::Texture2D::create(gl(), 2 * kWidth, 2 * kHeight, GL_RGBA8, "second output");
  const gl::Attachment attachments[] = {{GL_COLOR_ATTACHMENT0, &application.colour},
                                        {GL_COLOR_ATTACHMENT1, &other},
                                        {GL_DEPTH_STENCIL_ATTACHMENT, &application.depth}};
  application.framebuffer = *gl::Framebuffer::create(gl(), attachments, "two outputs");
  Engine drawn = engine();
  application.clear();
  gl().ClearNamedFramebufferfv(application.framebuffer.id(), GL_COLOR, 1, Application::kSky.data());
  gl::ExternalTarget target = application.target(17, 33, kWidth, kHeight);
  target.clear_depth = target.clear_colour = true;
  expect_frame(drawn, perspective(), target);

  const auto rgba = application.pixels();
  const auto depths = application.depths();
  const image::Image own = *drawn.read_colour();
  for (int y = 0; y < 2 * kHeight; ++y)
    for (int x = 0; x < 2 * kWidth; ++x) {
      const bool inside = x >= 17 && x < 17 + kWidth && y >= 33 && y < 33 + kHeight;
      const auto expected = inside ? pixel(own, x - 17, y - 33) : std::array<int, 3>{51, 102, 153};
      ASSERT_EQ(pixel(rgba, x, y, 2 * kWidth), expected) << x << ", " << y;
      if (!inside) {
        ASSERT_NEAR(depths[std::size_t(y * 2 * kWidth + x)], 0.7, 1e-6);
      }
    }
  std::vector<std::uint8_t> second(std::size_t(16 * kWidth * kHeight)), stencil(std::size_t(4 * kWidth * kHeight));
  other.read(0, GL_RGBA, GL_UNSIGNED_BYTE, std::as_writable_bytes(std::span(second)));
  for (std::size_t i = 0; i < second.size(); i += 4) ASSERT_EQ(int(second[i]), 51);
  application.depth.read(0, GL_STENCIL_INDEX, GL_UNSIGNED_BYTE, std::as_writable_bytes(std::span(stencil)));
  for (const std::uint8_t value : stencil) ASSERT_EQ(int(value), 3);
}

TEST_F(ExternalTarget, WhatIsDrawnFirstStaysWhereDepthsAreEqual) {
  core::Scene red;
  const core::MaterialId material = red.add_material({"red", {1.0f, 0.0f, 0.0f}, 1.0f});
  for (int i = 0; i < 5; ++i) {
    const core::Affine at = core::translation({4.0 * i, 11.0, 11.0});
    scene.add_primitive(scene.root(), core::Sphere{2.0f}, at);
    red.add_primitive(red.root(), core::Sphere{2.0f}, at, material);
  }
  for (const DepthMode& mode : kDepthModes) {
    const Application application(gl(), kWidth, kHeight, mode);
    Engine first = engine(), second = *Engine::create(red, config(CullerChoice::kCpu, kWidth, kHeight));
    application.clear();
    expect_frame(first, perspective(), application.target());
    const auto before = application.pixels();
    expect_frame(second, perspective(), application.target());
    EXPECT_TRUE(application.pixels() == before) << mode.name;
    EXPECT_GT(std::count(before.begin(), before.end(), 51), 0);
  }
}

/// Samples of the image and of the application's framebuffer.
TEST_F(ExternalTarget, SmoothEdgesAreBlendedWithWhatTheApplicationDrew) {
  fill(scene, 22);
  const core::View view = perspective();
  engine::EngineConfig four = config(CullerChoice::kCpu, kWidth, kHeight);
  four.drawing.samples = 4;
  Engine smooth = engine(four), rough = engine();

  // The mean of the covered samples, over the sky.
  const Application single(gl(), kWidth, kHeight);
  single.clear();
  expect_frame(smooth, view, single.target());
  const auto blended = single.pixels();

  // Each sample, resolved by the application: the same where one depth stands for all.
  const Application multi(gl(), kWidth, kHeight, kDepthModes[0], 4);
  multi.clear();
  expect_frame(smooth, view, multi.target());
  const Application resolved(gl(), kWidth, kHeight);
  gl().Disable(GL_SCISSOR_TEST);
  gl().BlitNamedFramebuffer(multi.framebuffer.id(), resolved.framebuffer.id(), 0, 0, kWidth, kHeight, 0, 0, kWidth,
                            kHeight, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  const auto each = resolved.pixels();

  // One sample, into all.
  multi.clear();
  expect_frame(rough, view, multi.target());
  gl().BlitNamedFramebuffer(multi.framebuffer.id(), resolved.framebuffer.id(), 0, 0, kWidth, kHeight, 0, 0, kWidth,
                            kHeight, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  const auto one = resolved.pixels();

  const image::Image rough_own = *rough.read_colour();
  const image::DepthImage rough_depth = *rough.read_depth(view);
  int mixed = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const auto a = pixel(blended, x, y), b = pixel(each, x, y);
      for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(a[c], b[c], 1) << x << ", " << y;
      const bool hit = !std::isinf(rough_depth.metres[std::size_t((kHeight - 1 - y) * kWidth + x)]);
      ASSERT_EQ(pixel(one, x, y), (hit ? pixel(rough_own, x, y) : std::array<int, 3>{51, 102, 153}));
      mixed += a != pixel(one, x, y);
    }
  EXPECT_GT(mixed, 300);
}

/// Each sample has the depth of the ray through its own place: that of an image which is moved by a part of a pixel.
TEST_F(ExternalTarget, DepthsAreThoseOfEachSample) {
  fill(scene, 22);
  engine::EngineConfig four = config(CullerChoice::kCpu, kWidth, kHeight);
  four.drawing.samples = 4;
  Engine smooth = engine(four), rough = engine();
  core::View cut = perspective();
  cut.sections = {{{0.3, 0.2, -1.0}, 6.0}};
  for (const core::View& view : {perspective(), cut}) {
    const Application application(gl(), kWidth, kHeight, kDepthModes[1], 4);
    application.clear();
    expect_frame(smooth, view, application.target());
    const std::vector<glm::vec2> offsets = engine::EngineParts::drawing(smooth)->target().sample_offsets();
    ASSERT_EQ(offsets.size(), 4u);
    int same = 0, edges = 0;
    for (int i = 0; i < 4; ++i) {
      const std::vector<float> depths = application.sample_depths(i);
      const double dx = offsets[std::size_t(i)].x, dy = -offsets[std::size_t(i)].y;  // y from above
      const core::View moved = *culling::rectangle_view(view, kWidth, kHeight, dx, dy, kWidth + dx, kHeight + dy);
      ASSERT_TRUE(rough.frame(moved));
      const image::DepthImage expected = *rough.read_depth(moved);
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const double reversed = depths[std::size_t(y * kWidth + x)];
          const double distance = 45.0 / (89.5 * reversed + 0.5);  // 90 where nothing is
          const double wanted = std::min(90.0, double(expected.metres[std::size_t((kHeight - 1 - y) * kWidth + x)]));
          std::abs(distance - wanted) <= 4e-6 * wanted* wanted ? ++same : ++edges;
        }
    }
    EXPECT_GT(same, 0);
    EXPECT_LE(edges, 8) << "where rays of another view may round to the other side of an edge";
  }
}

TEST_F(ExternalTarget, LinearColourIsDecoded) {
  fill(scene, 22);
  Application application(gl(), kWidth, kHeight);
  application.colour = *gl::Texture2D::create(gl(), kWidth, kHeight, GL_RGBA32F, "light");
  const gl::Attachment attachments[] = {{GL_COLOR_ATTACHMENT0, &application.colour},
                                        {GL_DEPTH_ATTACHMENT, &application.depth}};
  application.framebuffer = *gl::Framebuffer::create(gl(), attachments, "light");
  Engine drawn = engine();
  gl::ExternalTarget target = application.target();
  target.clear_colour = target.clear_depth = target.linear_colour = true;
  expect_frame(drawn, perspective(), target);
  std::vector<float> light(std::size_t(4 * kWidth * kHeight));
  application.colour.read(0, GL_RGBA, GL_FLOAT, std::as_writable_bytes(std::span(light)));
  const image::Image own = *drawn.read_colour();
  const auto linear = [](int byte) {
    const double s = byte / 255.0;
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  };
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(light[4 * std::size_t(y * kWidth + x) + c], linear(pixel(own, x, y)[c]), 4.5e-3) << x << ", " << y;
}

/// Windows are resized: other name, other size.
TEST_F(ExternalTarget, TheFramebufferMayChangeBetweenFrames) {
  fill(scene, 22);
  Engine drawn = engine();
  for (const auto& [width, height] : {std::pair(kWidth, kHeight), {61, 80}, {kWidth, kHeight}}) {
    const Application application(gl(), width, height);
    gl::ExternalTarget target = application.target();
    target.clear_colour = target.clear_depth = true;
    const core::View view =
        *core::View::perspective({{-9, -4, 20}, {11, 11, 11}, {0, 0, 1}}, 0.8, double(width) / height, 0.5, 90.0);
    expect_frame(drawn, view, target);
    engine::EngineConfig fresh_config = config(CullerChoice::kCpu, width, height);
    Engine fresh = engine(fresh_config);
    ASSERT_TRUE(fresh.frame(view));
    const image::Image own = *fresh.read_colour();
    const auto rgba = application.pixels();
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) ASSERT_EQ(pixel(rgba, x, y, width), pixel(own, x, y));
  }
}

/// At rest nothing is left to draw, but the application's framebuffer needs the image all the same.
TEST_F(ExternalTarget, EveryFrameOfABudgetPutsTheImageThere) {
  fill(scene, 22);
  engine::EngineConfig c = config(CullerChoice::kCpu, kWidth, kHeight);
  c.losses.budget_ms = 1000.0;
  Engine drawn = engine(c);
  const Application application(gl(), kWidth, kHeight);
  gl::ExternalTarget target = application.target();
  target.clear_colour = target.clear_depth = true;
  std::vector<std::uint8_t> first;
  for (int frame = 0; frame < 4; ++frame) {
    application.clear();
    expect_frame(drawn, perspective(), target);
    const auto rgba = application.pixels();
    if (frame == 1) first = rgba;
    if (frame > 1) {
      EXPECT_TRUE(rgba == first) << "frame " << frame;
    }
  }
  EXPECT_NE(pixel(first, kWidth / 2, kHeight / 2), (std::array<int, 3>{51, 102, 153}));
  // A frame without a target leaves the application's framebuffer alone.
  application.clear();
  ASSERT_TRUE(drawn.frame(perspective()));
  EXPECT_EQ(pixel(application.pixels(), kWidth / 2, kHeight / 2), (std::array<int, 3>{51, 102, 153}));
}

TEST_F(ExternalTarget, BadOnesAreErrorsAndNothingIsDrawn) {
  fill(scene, 22);
  Engine drawn = engine();
  const Application application(gl(), kWidth, kHeight);
  application.clear();
  const auto before = application.pixels();
  const auto refused = [&](const gl::ExternalTarget& target, const char* what) {
    const auto report = drawn.frame(perspective(), target);
    ASSERT_FALSE(report) << what;
    EXPECT_NE(report.error().message.find(what), std::string::npos) << report.error().message;
  };
  gl::ExternalTarget target = application.target();
  target.framebuffer = 4711;
  refused(target, "4711 is no framebuffer");
  target.framebuffer = 0;
  if (context->platform().starts_with("EGL")) refused(target, "the context has no window");  // others' have a pixel
  GLuint empty = 0;
  gl().CreateFramebuffers(1, &empty);
  target.framebuffer = empty;
  refused(target, "missing attachment");
  gl().DeleteFramebuffers(1, &empty);
  target = application.target();
  gl().NamedFramebufferDrawBuffer(target.framebuffer, GL_NONE);
  refused(target, "its draw buffer is GL_NONE");
  gl().NamedFramebufferDrawBuffer(target.framebuffer, GL_COLOR_ATTACHMENT0);
  target.near_depth = target.far_depth;
  refused(target, "two different depths");
  target = application.target();
  target.far_depth = std::numeric_limits<double>::quiet_NaN();
  refused(target, "two different depths");
  target = application.target();
  target.width = 0;
  refused(target, "0x64 pixels");
  target = application.target();
  target.x = std::numeric_limits<int>::max();
  refused(target, "expected a rectangle below 2^31 pixels");
  target = application.target();
  target.y = std::numeric_limits<int>::max() - target.height + 1;
  refused(target, "expected a rectangle below 2^31 pixels");
  target = application.target();
  target.width = 1 << 24;
  refused(target, "pixels wanted");
  EXPECT_TRUE(application.pixels() == before);
  expect_frame(drawn, perspective(), application.target());  // all is well again
  EXPECT_FALSE(application.pixels() == before);

  engine::EngineConfig own = config(CullerChoice::kCpu, kWidth, kHeight);
  own.context.application = nullptr;
  Engine offscreen = engine(own);
  const auto report = offscreen.frame(perspective(), application.target());
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("the application's EngineConfig::context.application"), std::string::npos);
  ASSERT_TRUE(context->make_current());
  engine::EngineConfig blind = config(CullerChoice::kGpu, kWidth, kHeight);
  blind.draw = false;
  EXPECT_FALSE(engine(blind).frame(perspective(), application.target()));
}

/// Two windows, two engines, one scene under edits.
TEST_F(ExternalTarget, EnginesOfOneSceneShowItsEditsInTheirFramebuffers) {
  fill(scene, 12);
  const core::View views[] = {
      *core::View::perspective({{-9, -4, 14}, {6, 6, 6}, {0, 0, 1}}, 0.8, double(kWidth) / kHeight, 0.5, 90.0),
      *core::View::orthographic({{20, 25, 14}, {6, 6, 6}, {0, 0, 1}}, 18.0, 1.0, 0.5, 90.0)};
  const Application windows[] = {{gl(), kWidth, kHeight, kDepthModes[0]}, {gl(), 70, 70, kDepthModes[1]}};
  Engine engines[] = {engine(config(CullerChoice::kCpu, kWidth, kHeight)),
                      engine(config(CullerChoice::kHybrid, 70, 70))};
  for (int round = 0; round < 6; ++round) {
    SCOPED_TRACE(testing::Message() << "round " << round);
    for (core::ItemId item = core::ItemId(round); to_index(item) < 12 * 12 * 12;
         item = core::ItemId{to_index(item) + 7})
      scene.set_visible(item, round % 2 == 1);
    scene.add_primitive(scene.root(), core::Sphere{1.0f}, core::translation({2.0 * round, 6.0, 14.0}));
    if (round == 4) {
      ASSERT_TRUE(engines[1].rebuild());
    }
    for (std::size_t w = 0; w < 2; ++w) {
      ASSERT_TRUE(engines[w].commit());
      windows[w].clear();
      expect_frame(engines[w], views[w], windows[w].target());
    }
    for (std::size_t w = 0; w < 2; ++w) {
      const Application fresh_window(gl(), windows[w].width(), windows[w].height(), windows[w].mode);
      Engine fresh = engine(config(CullerChoice::kCpu, windows[w].width(), windows[w].height()));
      fresh_window.clear();
      expect_frame(fresh, views[w], fresh_window.target());
      const auto is = windows[w].pixels(), expected = fresh_window.pixels();
      int most = 0;  // another order of the items has other chunk origins
      for (std::size_t i = 0; i < is.size(); ++i) most = std::max(most, std::abs(int(is[i]) - int(expected[i])));
      EXPECT_LE(most, 1) << "window " << w;
    }
  }
}

}  // namespace
}  // namespace sightline::tests::external_target_test
