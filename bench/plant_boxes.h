// Boxes like those of a process plant, for sizes that no file is at hand for.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "sightline/core/aabb.h"

namespace sightline::bench {

/// Pipe runs of straights and elbows with fittings in 400 x 100 x 60 m, whatever the count: more are denser. In the
/// order in which a designer would draw them, run by run. Depends on count and seed alone.
class PlantBoxes {
 public:
  explicit PlantBoxes(std::uint64_t seed) : state_(seed) {}

  std::vector<core::Aabb> make(std::size_t count) {
    boxes_.reserve(count + 64);
    while (boxes_.size() < count) run();
    boxes_.resize(count);
    return std::move(boxes_);
  }

 private:
  static constexpr double kSize[3] = {400.0, 100.0, 60.0};

  double unit() {  // SplitMix64
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return double((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }
  double spread(double low, double high) { return low * std::pow(high / low, unit()); }

  void add(const core::dvec3& a, const core::dvec3& b, double radius) {
    boxes_.push_back(core::round_outwards({glm::min(a, b) - radius, glm::max(a, b) + radius}, core::dvec3(0.0)));
  }

  void run() {
    core::dvec3 at(unit() * kSize[0], unit() * kSize[1], unit() * unit() * kSize[2]);
    const double radius = spread(0.02, 0.3);
    const int pieces = 4 + int(unit() * 40.0);
    int axis = int(unit() * 3.0);
    for (int i = 0; i < pieces; ++i) {
      const double length = std::min(spread(0.3, 12.0), 0.5 * kSize[axis]);
      core::dvec3 end = at;
      end[axis] += (at[axis] + length > kSize[axis] || (unit() < 0.5 && at[axis] > length)) ? -length : length;
      add(at, end, radius);
      for (double fitting = unit(); fitting < 0.4; fitting += 0.2) {  // flanges, valves, supports
        const core::dvec3 there = at + (end - at) * unit();
        add(there, there, radius * (1.1 + unit()));
      }
      add(end, end, 1.3 * radius);  // elbow
      at = end;
      axis = (axis + 1 + int(unit() * 2.0)) % 3;
    }
  }

  std::uint64_t state_;
  std::vector<core::Aabb> boxes_;
};

}  // namespace sightline::bench
