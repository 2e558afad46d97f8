// Boxes like those of a process plant, for sizes that no file is at hand for.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "sightline/apps/bench/models/random.h"
#include "sightline/core/aabb.h"

namespace sightline::bench {

/// Pipe runs of straights and elbows with fittings in 400 x 100 x 60 m, whatever the count: more are denser. In the
/// order in which a designer would draw them, run by run. Depends on count and seed alone.
class PlantBoxes {
 public:
  explicit PlantBoxes(std::uint64_t seed) : random_(seed) {}

  std::vector<core::Aabb> make(std::size_t count) {
    boxes_.reserve(count + 64);
    while (boxes_.size() < count) run();
    boxes_.resize(count);
    return std::move(boxes_);
  }

 private:
  static constexpr double kSize[3] = {400.0, 100.0, 60.0};

  void add(const core::dvec3& a, const core::dvec3& b, double radius) {
    boxes_.push_back(core::round_outwards({glm::min(a, b) - radius, glm::max(a, b) + radius}, core::dvec3(0.0)));
  }

  void run() {
    core::dvec3 at(random_.unit() * kSize[0], random_.unit() * kSize[1], random_.unit() * random_.unit() * kSize[2]);
    const double radius = random_.size(0.02, 0.3);
    const int pieces = 4 + int(random_.unit() * 40.0);
    int axis = int(random_.unit() * 3.0);
    for (int i = 0; i < pieces; ++i) {
      const double length = std::min(random_.size(0.3, 12.0), 0.5 * kSize[axis]);
      core::dvec3 end = at;
      end[axis] += (at[axis] + length > kSize[axis] || (random_.unit() < 0.5 && at[axis] > length)) ? -length : length;
      add(at, end, radius);
      for (double fitting = random_.unit(); fitting < 0.4; fitting += 0.2) {  // flanges, valves, supports
        const core::dvec3 there = at + (end - at) * random_.unit();
        add(there, there, radius * (1.1 + random_.unit()));
      }
      add(end, end, 1.3 * radius);  // elbow
      at = end;
      axis = (axis + 1 + int(random_.unit() * 2.0)) % 3;
    }
  }

  Random random_;
  std::vector<core::Aabb> boxes_;
};

}  // namespace sightline::bench
