#include "sightline/apps/bench/cylinder_rays/cylinder_rays.h"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "intersection_twin.h"
#include "sightline/gpuprims/internal/cylinder.h"
#include "sightline/tests/support/instruction_sets.h"

namespace sightline::gpuprims::cylinder_rays_test {
namespace {

using bench::first_crossings;
using bench::RayArrays;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Beam {
  std::vector<double> values[6], t_min;

  void add(const Ray& ray, double least) {
    for (int axis = 0; axis < 3; ++axis) {
      values[axis].push_back(ray.origin[axis]);
      values[3 + axis].push_back(ray.direction[axis]);
    }
    t_min.push_back(least);
  }
  Ray ray(std::size_t i) const {
    return {{values[0][i], values[1][i], values[2][i]}, {values[3][i], values[4][i], values[5][i]}};
  }
  std::vector<double> shoot(const core::Cylinder& cylinder, Caps caps) const {
    std::vector<double> t(t_min.size(), -1.0);
    const RayArrays rays{{values[0].data(), values[1].data(), values[2].data()},
                         {values[3].data(), values[4].data(), values[5].data()},
                         t.size()};
    first_crossings(cylinder, rays, t_min, caps, t);
    return t;
  }
};

double first_of(const Hits& hits, double least) {
  for (int i = 0; i < hits.count; ++i)
    if (hits.hit[i].t >= least) return hits.hit[i].t;
  return kInfinity;
}

/// Rays of the shapes that the twin is tested with, and some that start inside the cylinder.
Beam random_beam(twin::Random& random, const core::Cylinder& cylinder, int count) {
  Beam beam;
  while (int(beam.t_min.size()) < count) {
    const twin::Shot shot = random_shot(random, {cylinder.radius, cylinder.radius, 0.5 * cylinder.height});
    const double length = glm::length(shot.ray.direction);
    if (!(length > 1e-70 && length < 1e70)) continue;
    beam.add(shot.ray, random.below(2) ? -kInfinity : random.uniform(0.0, 1.0) * shot.aim);
  }
  return beam;
}

TEST(CylinderRays, AreThoseOfTheSingleRay) {
  tests::for_each_instruction_set([] {
    int hits = 0, rays = 0;
    for (unsigned seed = 0; seed < 500; ++seed) {
      SCOPED_TRACE(testing::Message() << "seed " << seed);
      twin::Random random(seed);
      const double scale = random.log_uniform(-6, 6);
      core::Cylinder cylinder{float(scale * random.log_uniform(-2, 2)), float(scale * random.log_uniform(-2, 2))};
      if (random.below(8) == 0) cylinder.height = 0.0f;
      const Caps caps{random.below(3) != 0, random.below(3) != 0};
      const Beam beam = random_beam(random, cylinder, 1 + random.below(70));  // every remainder of a vector
      const std::vector<double> t = beam.shoot(cylinder, caps);
      for (std::size_t i = 0; i < t.size(); ++i) {
        const double expected = first_of(intersect(cylinder, beam.ray(i), caps), beam.t_min[i]);
        ASSERT_EQ(t[i], expected) << "ray " << i;
        hits += std::isfinite(t[i]);
        ++rays;
      }
    }
    EXPECT_GT(hits, rays / 8);
  });
}

TEST(CylinderRays, UndefinedInputHitsNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  tests::for_each_instruction_set([&] {
    const core::Cylinder cylinder{1.0f, 2.0f};
    Beam beam;
    const Ray good{{0.1, 0.2, -5.0}, {0.01, 0.0, 1.0}};
    for (int axis = 0; axis < 3; ++axis) {
      for (const double bad : {nan, kInfinity, -kInfinity}) {
        Ray ray = good;
        ray.origin[axis] = bad;
        beam.add(ray, 0.0);
        ray = good;
        ray.direction[axis] = bad;
        beam.add(ray, 0.0);
      }
    }
    beam.add({good.origin, core::dvec3(0.0)}, 0.0);
    beam.add(good, nan);
    for (const double t : beam.shoot(cylinder, {})) EXPECT_EQ(t, kInfinity);
    for (const double t : beam.shoot({0.0f, 1.0f}, {})) EXPECT_EQ(t, kInfinity);
    for (const double t : beam.shoot({float(nan), 1.0f}, {})) EXPECT_EQ(t, kInfinity);
    EXPECT_TRUE(Beam().shoot(cylinder, {}).empty());
  });
}

}  // namespace
}  // namespace sightline::gpuprims::cylinder_rays_test
