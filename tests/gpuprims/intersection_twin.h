// The slow, obviously right twin of the reference intersections: marches along the ray in long double, asks a solid
// whether it contains each point, and halves every step in which the answer changes.
//
// A solid gives
//   shape                                    its parameters, what intersect() takes
//   dvec3 half() const                       half of a box about the local origin that contains it
//   bool inside(const LVec&)                 whether a point belongs to it
//   long double lateral(const LVec&)         a smooth function that is 0 on its curved surface and grows outwards
//   std::vector<core::dvec3> cap_normals()   outward normals of its flat faces
//   double size()                            radius of a sphere about the local origin that contains it
//   double feature()                         its smallest length
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims::twin {

using core::dvec3;
using LVec = glm::vec<3, long double>;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  double log_uniform(double low, double high) { return std::pow(10.0, uniform(low, high)); }
  int below(int n) { return static_cast<int>(engine_() % static_cast<unsigned>(n)); }
  dvec3 direction() {
    for (;;) {
      const dvec3 v(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
      const double length = glm::length(v);
      if (length > 0.1 && length <= 1.0) return v / length;
    }
  }

 private:
  std::mt19937 engine_;
};

/// A ray and the parameter at which it passes near the point it was aimed at.
struct Shot {
  Ray ray;
  double aim = 0.0;
};

/// A ray through a random point in or near a solid that fills the box -half … half: from outside and far outside, from
/// inside, parallel to the axis, on it, across it, and almost parallel to either; directions of ordinary and absurd
/// lengths.
inline Shot random_shot(Random& random, const dvec3& half) {
  const double size = glm::length(half);
  dvec3 target = half * dvec3(random.uniform(-1.1, 1.1), random.uniform(-1.1, 1.1), random.uniform(-1.1, 1.1));
  dvec3 direction = random.direction();
  const int shape = random.below(8);
  if (shape == 1) direction = {0.0, 0.0, random.below(2) ? 1.0 : -1.0};
  if (shape == 2) direction = glm::normalize(dvec3(direction.x, direction.y, 0.0));
  if (shape == 3) target = dvec3(0.0, 0.0, target.z);
  if (shape == 4)
    direction = glm::normalize(dvec3(random.log_uniform(-12, -2) * direction.x, 0.0, 1.0) + direction * 1e-9);
  if (shape == 5) direction = glm::normalize(dvec3(direction.x, direction.y, random.log_uniform(-12, -2)));
  if (shape == 6) direction = glm::normalize(half * direction);
  double distance = size * random.uniform(-0.5, 0.5);
  if (random.below(3)) distance = size * random.log_uniform(0, 4);
  if (random.below(16) == 0) target = dvec3(0.0), direction = {0.0, 0.0, 1.0};  // the axis itself
  const double length = random.below(8) ? random.log_uniform(-3, 3) : random.log_uniform(-150, 150);
  return {{target - distance * direction, direction * length}, distance / length};
}

inline LVec at(const Ray& ray, long double t) {
  return LVec(ray.origin) + t * LVec(ray.direction);
}

/// Parameters at which `inside` changes, in rising order. `aims` are looked at besides the regular steps.
template <class Solid>
std::vector<long double> march(const Solid& solid, const Ray& ray, const std::vector<double>& aims, int steps) {
  const LVec o(ray.origin), d(ray.direction);
  const long double speed = glm::length(d), closest = -glm::dot(o, d) / (speed * speed);
  const long double half = 1.01L * solid.size() / speed;
  std::vector<long double> samples(aims.begin(), aims.end());
  for (int i = 0; i <= steps; ++i) samples.push_back(closest + half * (2.0L * i / steps - 1.0L));
  std::sort(samples.begin(), samples.end());
  std::vector<long double> crossings;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    long double low = samples[i - 1], high = samples[i];
    const bool inside_low = solid.inside(at(ray, low));
    if (inside_low == solid.inside(at(ray, high))) continue;
    for (int k = 0; k < 70; ++k) {
      const long double middle = 0.5L * (low + high);
      (solid.inside(at(ray, middle)) == inside_low ? low : high) = middle;
    }
    crossings.push_back(0.5L * (low + high));
  }
  return crossings;
}

/// The gradient of solid.lateral by central differences.
template <class Solid>
dvec3 lateral_normal(const Solid& solid, const LVec& p) {
  const long double step = 1e-8L * solid.feature();
  LVec gradient(0.0L);
  for (int axis = 0; axis < 3; ++axis) {
    LVec offset(0.0L);
    offset[axis] = step;
    gradient[axis] = solid.lateral(p + offset) - solid.lateral(p - offset);
  }
  return dvec3(gradient / glm::length(gradient));
}

struct Tally {
  int rays = 0, hit = 0, crossings = 0;
  double worst = 0.0;  ///< largest distance between a crossing and its twin, by the solid's size
};

/// What an intersection must keep: crossings to kLength of the solid's size (grazing rays), and normals to kNormal,
/// those of flat faces to kFlat (both as 1 - cosine). Chords and gaps shorter than twice kLength may be missed.
inline constexpr double kLength = 1e-6, kNormal = 1e-6, kFlat = 1e-12;

/// Compares the crossings of a closed solid with the twin's.
template <class Solid>
void compare(const Solid& solid, const Shot& shot, const Hits& hits, Tally& tally) {
  const Ray& ray = shot.ray;
  const long double speed = glm::length(LVec(ray.direction)), size = solid.size();
  // What double can tell apart at the ray's origin, and the wanted share of the solid.
  const long double tolerance = (kLength * size + 1e-15L * glm::length(LVec(ray.origin))) / speed;
  ++tally.rays;
  tally.hit += hits.count > 0;
  tally.crossings += hits.count;
  ASSERT_EQ(hits.count % 2, 0) << "closed solid";

  std::vector<double> aims{shot.aim};
  for (int i = 0; i < hits.count; ++i) {
    ASSERT_TRUE(std::isfinite(hits.hit[i].t) && core::is_finite(hits.hit[i].normal)) << "crossing " << i;
    if (i) {
      ASSERT_LE(hits.hit[i - 1].t, hits.hit[i].t) << "crossing " << i;
      aims.push_back(0.5 * hits.hit[i - 1].t + 0.5 * hits.hit[i].t);
    }
  }

  const std::vector<long double> crossings = march(solid, ray, aims, 1000);
  for (std::size_t k = 0; k < crossings.size(); ++k) {
    const long double t = crossings[k];
    const bool near_last = k > 0 && t - crossings[k - 1] < 2.0L * tolerance;
    const bool near_next = k + 1 < crossings.size() && crossings[k + 1] - t < 2.0L * tolerance;
    if (near_last || near_next) continue;
    long double nearest = std::numeric_limits<long double>::infinity();
    for (int i = 0; i < hits.count; ++i) nearest = std::min(nearest, std::fabs(hits.hit[i].t - t));
    ASSERT_LE(double(nearest / tolerance), 1.0)
        << "missed the crossing at t = " << double(t) << " by " << double(nearest * speed / size) << " of the size; "
        << hits.count << " found";
    tally.worst = std::max(tally.worst, double(nearest * speed / size));
  }

  const std::vector<dvec3> caps = solid.cap_normals();
  for (int i = 0; i < hits.count; ++i) {
    const Hit& hit = hits.hit[i];
    const bool near_another = (i > 0 && hit.t - hits.hit[i - 1].t < 4.0L * tolerance) ||
                              (i + 1 < hits.count && hits.hit[i + 1].t - hit.t < 4.0L * tolerance);
    if (near_another) continue;
    ASSERT_EQ(solid.inside(at(ray, hit.t + 2.0L * tolerance)), i % 2 == 0) << "just behind crossing " << i;
    ASSERT_EQ(solid.inside(at(ray, hit.t - 2.0L * tolerance)), i % 2 == 1) << "just before crossing " << i;
    const dvec3 normal = glm::normalize(hit.normal);
    const double facing = glm::dot(normal, glm::normalize(ray.direction / glm::length(ray.direction)));
    if (i % 2 == 0) {
      ASSERT_LE(facing, kNormal) << "crossing " << i << " enters";
    } else {
      ASSERT_GE(facing, -kNormal) << "crossing " << i << " leaves";
    }
    double best = -1.0;
    for (const dvec3& cap : caps) best = std::max(best, glm::dot(glm::normalize(cap), normal));
    if (best < 1.0 - kFlat) {
      ASSERT_GE(glm::dot(lateral_normal(solid, at(ray, hit.t)), normal), 1.0 - kNormal) << "normal of crossing " << i;
    }
  }
}

/// `count` random solids and a ray at each: make(random) is a solid, aim(random, solid) a shot at it. At least
/// `hit_share` of the rays must hit, or the test would show nothing.
template <class Make, class Aim>
Tally run(unsigned count, double hit_share, const Make& make, const Aim& aim) {
  Tally tally;
  for (unsigned seed = 0; seed < count; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const auto solid = make(random);
    const Shot shot = aim(random, solid);
    compare(solid, shot, intersect(solid.shape, shot.ray), tally);
    if (testing::Test::HasFatalFailure()) return tally;
  }
  EXPECT_GT(tally.hit, hit_share * tally.rays);
  testing::Test::RecordProperty("worst_over_size", testing::PrintToString(tally.worst));
  return tally;
}
template <class Make>
Tally run(unsigned count, double hit_share, const Make& make) {
  return run(count, hit_share, make,
             [](Random& random, const auto& solid) { return random_shot(random, solid.half()); });
}

}  // namespace sightline::gpuprims::twin
