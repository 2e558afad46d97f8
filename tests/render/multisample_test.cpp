// Smooth edges: images with several samples per pixel against the mean of images of many times the pixels, and no
// light between neighbours that share a pixel.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::multisample_test {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec3;
using core::View;

constexpr int kWidth = 80, kHeight = 60;

class Multisample : public tests::GlTest {
 protected:
  image::Image image(core::Scene& scene, const View& view, int samples, int scale = 1) {
    engine::EngineConfig config;
    config.draw = true;
    config.width = scale * kWidth;
    config.height = scale * kHeight;
    config.drawing.samples = samples;
    config.context.application = &*context;
    auto engine = engine::Engine::create(scene, config);
    EXPECT_TRUE(engine) << engine.error().message;
    EXPECT_TRUE(engine->frame(view));
    engine->finish();
    EXPECT_TRUE(engine::EngineParts::drawing(*engine)->take_gl_errors().empty());
    return engine::EngineParts::drawing(*engine)->target().read_colour();
  }

  static View look(double distance = 4.0) {
    return *View::perspective({{distance, 0.3 * distance, 0.4 * distance}, {0, 0, 0}, {0, 0, 1}}, 0.7,
                              double(kWidth) / kHeight, 0.1);
  }
};

/// Each pixel the mean of scale x scale.
image::Image reduced(const image::Image& fine, int scale) {
  image::Image image{fine.width / scale, fine.height / scale, {}};
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) {
        int sum = 0;
        for (int j = 0; j < scale; ++j)
          for (int i = 0; i < scale; ++i)
            sum += fine.pixels[std::size_t(((scale * y + j) * fine.width + scale * x + i) * 3 + c)];
        image.pixels.push_back(std::uint8_t(std::lround(double(sum) / (scale * scale))));
      }
  return image;
}

double rms(const image::Image& a, const image::Image& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const double d = double(a.pixels[i]) - b.pixels[i];
    sum += d * d;
  }
  return std::sqrt(sum / double(a.pixels.size()));
}

TEST_F(Multisample, ComesCloserToTheMeanOfManyPixels) {
  const std::pair<const char*, core::Primitive> solids[] = {
      {"cylinder", core::Cylinder{0.7f, 2.0f}},
      {"snout", core::Snout{1.0f, 0.4f, 1.6f, 0.3f, 0, 0.2f, 0, 0, 0}},
      {"circular torus", core::CircularTorus{1.0f, 0.35f, 4.0f}},
      {"sphere", core::Sphere{2.0f}},
      {"elliptical dish", core::EllipticalDish{1.0f, 0.5f}},
      {"rectangular torus", core::RectangularTorus{0.5f, 1.2f, 0.5f, 4.0f}},
      {"pyramid", core::Pyramid{1.5f, 1.2f, 0.5f, 0.6f, 0.2f, 0.1f, 1.5f}},
      {"box", core::Box{1.4f, 1.2f, 1.0f}}};
  for (const auto& [name, solid] : solids) {
    SCOPED_TRACE(name);
    core::Scene scene;
    scene.add_primitive(scene.add_node(scene.root(), "item"), solid);
    const image::Image reference = reduced(image(scene, look(), 1, 8), 8);
    const double jagged = rms(image(scene, look(), 1), reference), smooth = rms(image(scene, look(), 4), reference);
    EXPECT_LT(smooth, 0.65 * jagged) << "rms over the image";
  }
}

core::MaterialId black(core::Scene& scene) {
  core::Material material;
  material.colour = core::vec3(0.0f);
  return scene.add_material(material);
}

TEST_F(Multisample, ShowsNothingBetweenPipesThatMeet) {
  // A black pipe in two pieces looks like the pipe in one but for gloss, which each piece takes at a sample of its own;
  // a sample of background between them would add 50 and more.
  core::Scene whole, halves;
  const dmat3 turn = {{0.36, 0.48, -0.8}, {-0.8, 0.6, 0.0}, {0.48, 0.64, 0.6}};
  whole.add_primitive(whole.add_node(whole.root(), "pipe", {turn, dvec3(0)}), core::Cylinder{0.5f, 4.0f}, {},
                      black(whole));
  for (const double side : {-1.0, 1.0})
    halves.add_primitive(halves.add_node(halves.root(), "half", {turn, side * turn[2]}), core::Cylinder{0.5f, 2.0f}, {},
                         black(halves));
  const View view = look(6.0);
  const auto difference = image::compare(image(whole, view, 4), image(halves, view, 4));
  ASSERT_TRUE(difference);
  EXPECT_LE(difference->max, 24);
}

/// A context that lacks a number takes the next one it has; every sample of that is drawn.
TEST_F(Multisample, EveryNumberOfSamplesIsDrawnWhole) {
  core::Scene scene;
  scene.add_primitive(scene.root(), core::Box{60.0f, 60.0f, 60.0f}, core::translation({-40.0, 0.0, 0.0}));
  const image::Image one = image(scene, look(), 1);
  for (const int samples : {2, 3, 4}) {
    const auto difference = image::compare(one, image(scene, look(), samples));
    ASSERT_TRUE(difference);
    EXPECT_LE(difference->max, 1) << samples << " samples of an image that one face fills";
  }
}

TEST_F(Multisample, SaysHowManySamplesTheContextHas) {
  GLint most = 0;
  gl().GetIntegerv(GL_MAX_SAMPLES, &most);
  if (most >= render::kMostSamples) GTEST_SKIP() << "the context has " << most;
  auto target = render::RenderTarget::create(*context, 8, 8, {.samples = render::kMostSamples});
  ASSERT_FALSE(target);
  EXPECT_NE(target.error().message.find("32 samples"), std::string::npos) << target.error().message;
}

/// Whatever the context has: what shaders say of samples is a word.
TEST_F(Multisample, SaysHowManySamplesShadersKnow) {
  auto target = render::RenderTarget::create(*context, 8, 8, {.samples = render::kMostSamples + 1});
  ASSERT_FALSE(target);
  EXPECT_EQ(target.error().message, "render target: 33 samples wanted, 32 are the most");
}

}  // namespace
}  // namespace sightline::multisample_test
