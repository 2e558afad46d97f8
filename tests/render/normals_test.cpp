// The normal image: what surfaces are shaded with, of ray-cast and of rasterised batches, and nothing for who does not
// ask.
#include <cmath>

#include <gtest/gtest.h>

#include "sightline/core/snapshot.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/render/internal/renderer.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::normals_test {
namespace {

using core::dvec3;

constexpr int kWidth = 96, kHeight = 64;
const dvec3 kCentre(5.0, -3.0, 2.0);
constexpr double kRadius = 0.8;

class Normals : public tests::GlTest {
 protected:
  struct Drawn {
    image::Image colour;
    image::DepthImage depth;
    image::NormalImage normals;
  };

  static core::View view() {
    return *core::View::perspective({kCentre + dvec3(2.0, -1.5, 1.0), kCentre, {0, 0, 1}}, 0.8,
                                    double(kWidth) / kHeight, 0.1);
  }

  Drawn draw(core::Scene& scene, bool with_normals) {
    EXPECT_TRUE(scene.commit());
    core::Snapshot snapshot(scene);
    auto gpu = gpuscene::GpuScene::create(*context, snapshot);
    auto lists = gpuscene::DrawLists::create(*context, *gpu);
    auto renderer = render::Renderer::create(*context, *gpu, {.normals = with_normals});
    auto target = render::RenderTarget::create(*context, kWidth, kHeight, {.normals = with_normals});
    EXPECT_TRUE(renderer) << renderer.error().message;
    EXPECT_EQ(target->has_normals(), with_normals);
    core::VisibleSet all;
    all.generation = snapshot.generation();
    all.ranges.push_back({0, std::uint32_t(snapshot.size())});
    EXPECT_TRUE(lists->update(snapshot, *gpu, all));
    EXPECT_TRUE(renderer->draw(view(), snapshot, *gpu, *lists, *target));
    return {target->read_colour(), target->read_depth(view()),
            with_normals ? target->read_normals() : image::NormalImage{}};
  }

  /// Every normal of a ball points away from its centre, `degrees` at most beside.
  static void expect_ball(const Drawn& drawn, double degrees) {
    const core::dmat4 eye_from_world = view().eye_from_world(), clip = view().clip_from_eye();
    const dvec3 centre(eye_from_world * core::dvec4(kCentre, 1.0));
    int hits = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const std::size_t i = std::size_t(y) * kWidth + std::size_t(x);
        const auto& n = drawn.normals.normals[i];
        const dvec3 normal(n[0], n[1], n[2]);
        const double depth = drawn.depth.metres[i];
        if (!std::isfinite(depth)) {
          ASSERT_EQ(normal, dvec3(0.0));
          continue;
        }
        ++hits;
        const dvec3 p = depth * dvec3((2.0 * (x + 0.5) / kWidth - 1.0) / clip[0][0],
                                      (1.0 - 2.0 * (y + 0.5) / kHeight) / clip[1][1], -1.0);
        ASSERT_NEAR(glm::length(normal), 1.0, 1e-5);
        ASSERT_GE(glm::dot(normal, glm::normalize(p - centre)), std::cos(glm::radians(degrees))) << x << ", " << y;
      }
    EXPECT_GT(hits, 500);
  }
};

TEST_F(Normals, OfARayCastBall) {
  core::Scene scene;
  scene.add_primitive(scene.root(), core::Sphere{float(2.0 * kRadius)}, core::translation(kCentre));
  expect_ball(draw(scene, true), 0.05);
}

TEST_F(Normals, OfAMesh) {
  core::Scene scene;
  const core::Mesh mesh = gpuprims::tessellate(core::Sphere{float(2.0 * kRadius)}, {.fixed_segments = 96});
  scene.add_mesh_instance(scene.root(), scene.add_mesh(mesh).value(), core::translation(kCentre));
  expect_ball(draw(scene, true), 2.5);
}

TEST_F(Normals, ChangeNothingElse) {
  core::Scene scene;
  scene.add_primitive(scene.root(), core::Sphere{1.6f}, core::translation(kCentre));
  scene.add_primitive(scene.root(), core::Box{1.0f, 0.5f, 2.0f}, core::translation(kCentre + dvec3(0.5, 0.3, 0)));
  const Drawn with = draw(scene, true), without = draw(scene, false);
  EXPECT_EQ(with.colour.pixels, without.colour.pixels);
  EXPECT_EQ(with.depth.metres, without.depth.metres);
}

}  // namespace
}  // namespace sightline::normals_test
