// Bounding volume hierarchies by the binned surface-area heuristic (I. Wald, "On fast construction of SAH-based
// bounding volume hierarchies", 2007), and their traversal with a stack.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/apps/study/rays/query.h"
#include "sightline/core/aabb.h"

namespace sightline::study::rays {

struct Bvh {
  static constexpr std::uint32_t kMaxDepth = 96;
  /// In an inner node `first` is the left child, the right one lies beside it, and count is 0.
  struct Node {
    core::Aabb box;
    std::uint32_t first = 0, count = 0;
    bool is_leaf() const { return count != 0; }
  };
  std::vector<Node> nodes;  ///< nodes[0] is the root; empty for no boxes
  std::vector<std::uint32_t> triangles;

  std::size_t bytes() const { return nodes.size() * sizeof(Node) + triangles.size() * sizeof(std::uint32_t); }
};

/// Deterministic. Where the heuristic finds no split, or sinks too deep, ranges are halved.
Bvh build_bvh(std::span<const core::Aabb> boxes, std::uint32_t leaf_size = 4);

/// Tests both children's boxes and goes to the nearer one first. The other waits on a stack of 4 bytes an entry.
struct BvhStack {
  template <class Q>
  static void walk(const Bvh& bvh, const UnitRay& ray, Q& query) {
    std::array<std::uint32_t, Bvh::kMaxDepth> stack;
    std::size_t size = 0;
    std::uint32_t index = 0;
    for (;;) {
      query.visit();
      const Bvh::Node& node = bvh.nodes[index];
      if (node.is_leaf()) {
        // Subtrees overlap: only an empty stack, or any hit, ends the search.
        if (query.test({bvh.triangles.data() + node.first, node.count}, kNowhere)) return;
      } else {
        const float limit = std::min(ray.exit, query.nearest());
        const float left = entry_of(bvh.nodes[node.first].box, ray, limit);
        const float right = entry_of(bvh.nodes[node.first + 1].box, ray, limit);
        const bool right_first = right < left;
        if (left != kMissed && right != kMissed) stack[size++] = node.first + std::uint32_t(!right_first);
        if (left != kMissed || right != kMissed) {
          index = node.first + std::uint32_t(right_first);
          continue;
        }
      }
      if (size == 0) return;
      index = stack[--size];
    }
  }

 private:
  static constexpr float kMissed = std::numeric_limits<float>::infinity();
  static constexpr float kNowhere = -1.0f;

  /// Parameter where the ray enters the box at or before `limit`.
  static float entry_of(const core::Aabb& box, const UnitRay& ray, float limit) {
    const core::vec3 a = (box.min - ray.origin) * ray.inverse, b = (box.max - ray.origin) * ray.inverse;
    const core::vec3 low = glm::min(a, b), high = glm::max(a, b);
    const float entry = std::max({low.x, low.y, low.z, 0.0f});
    return entry <= std::min({high.x, high.y, high.z, limit}) ? entry : kMissed;
  }
};

}  // namespace sightline::study::rays
