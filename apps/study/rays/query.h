// A traversal is asked for the nearest hit of a ray or for any hit, with or without counters.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "sightline/apps/study/rays/triangle_set.h"

namespace sightline::study::rays {

struct Counters {
  std::uint64_t nodes = 0;      ///< visited: inner nodes, leaves and cells, each time
  std::uint64_t triangles = 0;  ///< tested, each time
};

enum class Find : std::uint8_t { kNearest, kAny };

/// Part of a ray.
struct Interval {
  float min, max;
};

/// An entry of most stacks: a node, and the part of the ray in it.
struct Entry {
  std::uint32_t node;
  Interval t;
};

/// A traversal calls visit() at each node or cell, and test() with the triangles of each leaf, front to back.
template <Find find, bool counting>
class Query {
 public:
  Query(const TriangleSet& triangles, const Ray& ray, const UnitRay& unit)
      : triangles_(triangles), sheared_(ray), unit_(unit) {
    hit_.t = ray.t_max;
  }

  void visit(std::uint32_t nodes = 1) {
    if constexpr (counting) counters_.nodes += nodes;
  }

  /// Tests a leaf's triangles. True ends the search: any hit was wanted, or the nearest lies not behind `exit`, the
  /// parameter up to which everything has been tested.
  bool test(std::span<const std::uint32_t> triangles, float exit) {
    if constexpr (counting) counters_.triangles += triangles.size();
    for (const std::uint32_t i : triangles) {
      const double t = triangles_.intersect(sheared_, i, hit_.t);
      if (t == std::numeric_limits<double>::infinity() || (t == hit_.t && i >= hit_.triangle)) continue;
      hit_ = {t, i};
      if constexpr (find == Find::kAny) return true;
      nearest_ = unit_.from_ray(t);
    }
    return nearest_ <= exit;
  }

  /// Parameter of the nearest hit so far; infinity for none.
  float nearest() const { return nearest_; }
  Hit hit() const { return hit_ ? hit_ : Hit{}; }
  const Counters& counters() const { return counters_; }

 private:
  const TriangleSet& triangles_;
  ShearedRay sheared_;
  const UnitRay& unit_;
  Hit hit_;
  float nearest_ = std::numeric_limits<float>::infinity();
  Counters counters_;
};

}  // namespace sightline::study::rays
