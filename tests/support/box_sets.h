// Boxes that builders of hierarchies and orders find hard.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "sightline/core/aabb.h"

namespace sightline::tests {

inline float uniform_float(std::mt19937_64& random, double low, double high) {
  return float(std::uniform_real_distribution<double>(low, high)(random));
}

inline std::vector<core::Aabb> boxes_in_a_site(std::size_t count, std::uint64_t seed, double site = 1000.0,
                                               double size = 5.0) {
  std::mt19937_64 random(seed);
  std::vector<core::Aabb> boxes(count);
  for (core::Aabb& b : boxes) {
    for (int i = 0; i < 3; ++i) {
      b.min[i] = uniform_float(random, -site, site);
      b.max[i] = b.min[i] + uniform_float(random, 0.0, size);
    }
  }
  return boxes;
}

/// By name: coincident centroids, denormal and huge extents, giants among dust, exponential spacing, empty boxes.
inline std::vector<std::pair<std::string, std::vector<core::Aabb>>> hard_box_sets() {
  using core::Aabb, core::vec3;
  std::vector<Aabb> shells;  // no plane parts their centroids
  for (int i = 1; i <= 20000; ++i) shells.push_back({vec3(-float(i)), vec3(float(i))});

  constexpr float kTiny = std::numeric_limits<float>::denorm_min(), kMost = std::numeric_limits<float>::max();
  std::mt19937_64 random(1);
  std::vector<Aabb> denormal, huge, mixed;
  for (int i = 0; i < 5000; ++i) {
    const auto point = [&] {
      vec3 p;
      for (int a = 0; a < 3; ++a) p[a] = uniform_float(random, -1e38, 1e38);
      return p;
    };
    vec3 p;
    for (int a = 0; a < 3; ++a) p[a] = kTiny * float(random() % 1000);
    denormal.push_back({p, p + vec3(kTiny)});
    const vec3 q = point(), r = point();
    huge.push_back({glm::min(q, r), glm::max(q, r)});
    mixed.push_back(i % 3 == 0 ? denormal.back() : i % 3 == 1 ? huge.back() : Aabb{vec3(-1.0f), vec3(1.0f)});
  }
  mixed.push_back({vec3(-kMost), vec3(kMost)});
  mixed.push_back({vec3(-kMost), vec3(-kMost)});
  mixed.push_back({vec3(kMost), vec3(kMost)});

  std::vector<Aabb> giants = boxes_in_a_site(20000, 3, 1.0, 1e-4);
  giants.push_back({vec3(-1e30f), vec3(1e30f)});
  giants.push_back({vec3(1e30f), vec3(2e30f)});

  std::vector<Aabb> exponential, both_ways;  // every split into equal bins takes one box off
  for (int copies = 0; copies < 40; ++copies)
    for (int i = 0; i < 140; ++i) {
      const float x = std::ldexp(1.0f, -i);
      exponential.push_back({vec3(x, 0, 0), vec3(1.01f * x, 1e-3f * x, 0)});
    }
  for (int i = -140; i < 120; ++i) {
    const float x = std::ldexp(1.0f, i);
    both_ways.push_back({vec3(x), vec3(x)});
    both_ways.push_back({vec3(-x), vec3(-x)});
  }

  std::vector<Aabb> some_empty = boxes_in_a_site(5000, 4);
  for (Aabb& b : some_empty)
    if (random() % 3 == 0) b = {};

  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::vector<Aabb> whole_space = boxes_in_a_site(40'000, 5);
  for (std::size_t i = 0; i < whole_space.size(); i += 7) whole_space[i] = {vec3(-kInfinity), vec3(kInfinity)};

  return {{"shells", shells},
          {"denormal", denormal},
          {"huge", huge},
          {"mixed", mixed},
          {"giants", giants},
          {"exponential", exponential},
          {"both ways", both_ways},
          {"some empty", some_empty},
          {"all empty", std::vector<Aabb>(1000)},
          {"whole space", whole_space}};
}

}  // namespace sightline::tests
