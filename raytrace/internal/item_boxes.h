// Boxes in place of items that are not in memory, as rays meet them. Internal to raytrace and engine.
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <span>
#include <vector>

#include "sightline/core/item_bounds.h"
#include "sightline/core/ray.h"
#include "sightline/raytrace/internal/item_trees.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::raytrace {

/// The space between four rays of an image, those of the corners of a rectangle in turn.
class Beam {
 public:
  explicit Beam(const std::array<core::Ray, 4>& corners);
  /// Whether a box may lie in it; true for some that do not.
  bool may_meet(const core::AabbD& box) const;
  /// No ray of it enters the box before this t.
  double first(const core::AabbD& box) const;

 private:
  core::Ray corner_;
  bool parallel_;
  std::array<core::Plane, 4> sides_;  // towards the inside
};

class ItemBoxes {
 public:
  /// `bounds` must outlive it and stay as they are.
  ItemBoxes(const core::ItemBounds& bounds, int threads) : bounds_(bounds), items_(bounds, threads) {}

  /// Where a ray enters a box. slot: core::kNone: it enters none.
  struct Entry {
    core::Slot slot = core::kNone;
    double t = 0.0;
    core::dvec3 normal{0.0};  ///< of the face, outwards
  };
  /// The first one; of several at the very same t, that of the lowest slot. Boxes in which the ray, or a part of it
  /// that section planes keep, begins are not there: from within they show what they hold.
  Entry nearest(const core::Ray& ray, const RayFilter& filter) const;
  /// For each of many rays, which are faster together if neighbours follow one another. Touching boxes may take turns.
  void nearest(std::span<const core::Ray> rays, const RayFilter& filter, std::span<Entry> entries) const;
  /// Calls visit(slot, first t) for the boxes that a beam may meet, nearest first, up to `limit`, which visit() may
  /// change.
  template <class Visit>
  void find(const Beam& beam, const double& limit, const Visit& visit) const {
    std::vector<Ahead> ahead;
    for (const ItemTrees::Tree& tree : items_.trees()) ahead.push_back({-kInfinity, tree.root});
    while (!ahead.empty()) {
      std::pop_heap(ahead.begin(), ahead.end());
      const auto [t, child] = ahead.back();
      ahead.pop_back();
      if (t > limit) return;
      if ((child & kLeafBit) != 0)
        visit(core::Slot(child & ~kLeafBit), t);
      else
        look_into(items_.nodes()[child], beam, ahead);
    }
  }

  /// Calls visit(slot) for the boxes that a ray may meet.
  void find(const core::Ray& ray, const std::function<void(core::Slot)>& visit) const;

  std::size_t memory_bytes() const { return items_.memory_bytes(); }

 private:
  /// A node or a box that a beam may meet.
  struct Ahead {
    double t;
    std::uint32_t child;
    bool operator<(const Ahead& other) const { return t > other.t; }
  };
  class Packet;
  void look_into(const WideNode& node, const Beam& beam, std::vector<Ahead>& ahead) const;

  const core::ItemBounds& bounds_;
  ItemTrees items_;
};

}  // namespace sightline::raytrace
