#include "sightline/core/image_rays.h"

#include <limits>

#include <gtest/gtest.h>

#include "sightline/core/conventions.h"
#include "sightline/tests/core/primitive_samples.h"

namespace sightline::core::image_rays_test {
namespace {

using tests::Random;
using tests::uniform;

bool chance(Random& random, double probability) {
  return uniform(random, 0.0, 1.0) < probability;
}
dvec3 point(Random& random, double half) {
  const double x = uniform(random, -half, half), y = uniform(random, -half, half);
  return {x, y, uniform(random, -half, half)};
}

TEST(ImageRays, RefusesImagesOfNothing) {
  const View view = *View::perspective({{0, -20, 3}, {0, 0, 0}, {0, 0, 1}}, 0.6, 1.5, 0.1);
  EXPECT_TRUE(ImageRays::create(view, 30, 20));
  EXPECT_FALSE(ImageRays::create(view, 0, 20));
  EXPECT_FALSE(ImageRays::create(view, 30, -1));
  EXPECT_FALSE(image_ray(view, 30, 20, std::numeric_limits<double>::quiet_NaN(), 1.0));
  dmat4 flat = view.clip_from_eye();
  flat[0] = dvec4(0.0);
  const auto singular = View::from_matrices(view.eye_from_world(), flat, view.clip_depth());
  ASSERT_TRUE(singular);
  EXPECT_FALSE(image_ray(*singular, 30, 20, 1.0, 1.0));
}

/// A view of any convention, stretched or mirrored, with its matrices apart or as their product.
View view_of_matrices(Random& random) {
  const Pose pose{point(random, 10.0), point(random, 10.0), {0, 0, 1}};
  const bool parallel = chance(random, 0.3);
  const auto depth = ClipDepth(int(uniform(random, 0.0, 3.0)));
  const View like = parallel ? *View::orthographic(pose, 3.0, 1.5, -2.0, 40.0)
                             : *View::asymmetric(pose, -0.1, 0.3, -0.2, 0.25, 0.5, 50.0);
  dmat4 eye = like.eye_from_world(), clip = like.clip_from_eye();
  for (int axis = 0; axis < 3; ++axis)
    for (int row = 0; row < 3; ++row) eye[axis][row] *= axis == 1 ? uniform(random, 0.5, 2.0) : 1.0;
  if (chance(random, 0.3)) clip = dmat4(glm::dvec4(-1, 0, 0, 0), {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}) * clip;
  const double near = near_depth(depth), far = far_depth(depth);
  clip = dmat4(glm::dvec4(1, 0, 0, 0), {0, 1, 0, 0}, {0, 0, near - far, 0}, {0, 0, far, 1}) * clip;
  if (chance(random, 0.3)) return *View::from_matrices(dmat4(1.0), clip * eye, depth);
  return *View::from_matrices(eye, clip, depth);
}

/// The slow way: both ends by the inverse of the whole projection.
TEST(ImageRays, RunsFromTheNearToTheFarPlane) {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const View view = view_of_matrices(random);
    const dmat4 world_from_clip = glm::inverse(view.clip_from_world());
    const double x = uniform(random, 0.0, 300.0), y = uniform(random, 0.0, 200.0);
    const auto in_world = [&](double depth) {
      const dvec4 p = world_from_clip * dvec4(2.0 * x / 300.0 - 1.0, 1.0 - 2.0 * y / 200.0, depth, 1.0);
      return dvec3(p) / p.w;
    };
    const dvec3 near = in_world(near_depth(view.clip_depth())), far = in_world(far_depth(view.clip_depth()));
    const auto ray = image_ray(view, 300, 200, x, y);
    ASSERT_TRUE(ray);
    ASSERT_NEAR(glm::length(ray->direction), 1.0, 1e-12);
    ASSERT_LT(glm::length(ray->origin + ray->t_min * ray->direction - near), 1e-9);
    ASSERT_LT(glm::length(ray->origin + ray->t_max * ray->direction - far), 1e-8 * glm::length(far - near));
    ASSERT_LT(ray->t_min, ray->t_max);
  }
}

TEST(ImageRays, PassesThroughThePixel) {
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    const dvec3 eye = point(random, 1e4);
    const Pose pose{eye, eye + tests::random_direction(random), {0, 0, 1}};
    const bool parallel = chance(random, 0.3);
    const double far = chance(random, 0.5) ? kInfiniteFar : 50.0;
    const View view = parallel ? *View::orthographic(pose, 3.0, 1.5, -2.0, 40.0)
                               : *View::asymmetric(pose, -0.1, 0.3, -0.2, 0.25, 0.5, far);
    const double x = uniform(random, 0.0, 300.0), y = uniform(random, 0.0, 200.0);
    const auto ray = image_ray(view, 300, 200, x, y);
    ASSERT_TRUE(ray);
    EXPECT_NEAR(glm::length(ray->direction), 1.0, 1e-12);
    const auto ndc = [&](double t) {
      const dvec4 p = view.clip_from_world() * dvec4(ray->origin + t * ray->direction, 1.0);
      return dvec3(p) / p.w;
    };
    const dvec3 near = ndc(ray->t_min);
    EXPECT_NEAR(near.z, 1.0, 1e-8);
    EXPECT_NEAR(near.x, 2.0 * x / 300.0 - 1.0, 1e-8);
    EXPECT_NEAR(near.y, 1.0 - 2.0 * y / 200.0, 1e-8);
    if (parallel || far < kInfiniteFar) {
      EXPECT_NEAR(ndc(ray->t_max).z, 0.0, 1e-8);
    } else {
      EXPECT_EQ(ray->t_max, std::numeric_limits<double>::infinity());
    }
    if (!parallel) {
      EXPECT_LT(glm::length(ray->origin - eye), 1e-9);
    }
  }
}

}  // namespace
}  // namespace sightline::core::image_rays_test
