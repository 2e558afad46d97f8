// Bounding interval hierarchies (C. Wächter, A. Keller, "Instant Ray Tracing: The Bounding Interval Hierarchy", 2006).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/apps/study/rays/query.h"
#include "sightline/core/aabb.h"

namespace sightline::study::rays {

struct Bih {
  static constexpr std::uint32_t kMaxDepth = 96;
  /// Twelve bytes. An inner node's left child ends at `left_end` across the axis, its right child, which lies beside
  /// it, begins at `right_begin`; they may overlap or leave a gap. A leaf keeps its range in the same place.
  class Node {
   public:
    static Node inner(int axis, std::uint32_t left, float left_end, float right_begin) {
      return {left << 2 | std::uint32_t(axis), std::bit_cast<std::uint32_t>(left_end),
              std::bit_cast<std::uint32_t>(right_begin)};
    }
    static Node leaf(std::uint32_t first, std::uint32_t count) { return {3u, first, count}; }
    Node() = default;
    bool is_leaf() const { return (bits_ & 3u) == 3u; }
    int axis() const { return int(bits_ & 3u); }
    std::uint32_t left() const { return bits_ >> 2; }
    float left_end() const { return std::bit_cast<float>(a_); }
    float right_begin() const { return std::bit_cast<float>(b_); }
    std::uint32_t first() const { return a_; }
    std::uint32_t count() const { return b_; }

   private:
    Node(std::uint32_t bits, std::uint32_t a, std::uint32_t b) : bits_(bits), a_(a), b_(b) {}
    std::uint32_t bits_ = 3u, a_ = 0, b_ = 0;
  };
  std::vector<Node> nodes;  ///< nodes[0] is the root; never empty
  std::vector<std::uint32_t> triangles;

  std::size_t bytes() const { return nodes.size() * sizeof(Node) + triangles.size() * sizeof(std::uint32_t); }
};

/// Halves space across its longest axis, as a kd-tree would at its middle, and gives each box to the side of its
/// centre. Ranges that this does not separate are halved by number.
Bih build_bih(std::span<const core::Aabb> boxes, const core::Aabb& bounds, std::uint32_t leaf_size = 4);

/// The far child waits with its interval on a stack of 12 bytes an entry.
struct BihStack {
  template <class Q>
  static void walk(const Bih& bih, const UnitRay& ray, Q& query) {
    std::array<Entry, Bih::kMaxDepth> stack;
    std::size_t size = 0;
    Entry at{0, {0.0f, ray.exit}};
    for (;;) {
      query.visit();
      const Bih::Node& n = bih.nodes[at.node];
      if (n.is_leaf()) {
        if (query.test({bih.triangles.data() + n.first(), n.count()}, kNowhere)) return;
      } else {
        const bool negative = ray.negative(n.axis());
        const float near_end = ray.at(n.axis(), negative ? n.right_begin() : n.left_end());
        const float far_begin = ray.at(n.axis(), negative ? n.left_end() : n.right_begin());
        const bool near = near_end >= at.t.min, far = far_begin <= at.t.max;
        const Entry far_entry{n.left() + std::uint32_t(!negative), {std::max(at.t.min, far_begin), at.t.max}};
        if (near) {
          if (far) stack[size++] = far_entry;
          at = {n.left() + std::uint32_t(negative), {at.t.min, std::min(at.t.max, near_end)}};
          continue;
        }
        if (far) {
          at = far_entry;
          continue;
        }
      }
      do {
        if (size == 0) return;
        at = stack[--size];
      } while (at.t.min > query.nearest());
    }
  }

 private:
  static constexpr float kNowhere = -1.0f;
};

}  // namespace sightline::study::rays
