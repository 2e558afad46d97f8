// Octrees, and the parametric traversal of J. Revelles, C. Ureña, M. Lastra, "An Efficient Parametric Algorithm for
// Octree Traversal" (2000).
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/apps/study/rays/query.h"
#include "sightline/core/aabb.h"

namespace sightline::study::rays {

struct Octree {
  /// Children lie side by side from `first` on, child i on the high side of the axes of its bits (x 1, y 2, z 4). A
  /// leaf's triangles are `count` indices from `first` on.
  struct Node {
    static constexpr std::uint32_t kInner = core::kNone;
    std::uint32_t first = 0, count = 0;
    bool is_leaf() const { return count != kInner; }
  };
  std::vector<Node> nodes;  ///< nodes[0] is the root; never empty
  std::vector<std::uint32_t> triangles;
  core::Aabb bounds;

  std::size_t bytes() const { return nodes.size() * sizeof(Node) + triangles.size() * sizeof(std::uint32_t); }
};

/// Nodes of more than `leaf_size` boxes are split, up to a depth that grows with log4 of the number of boxes: that many
/// equal ones cover a surface.
Octree build_octree(std::span<const core::Aabb> boxes, const core::Aabb& bounds, std::uint32_t leaf_size = 8);

/// The ray is mirrored so that its direction is positive; a node is known by the parameters where the ray meets its low
/// and high planes, and a plane in the middle has their mean.
struct OctreeRevelles {
  template <class Q>
  static void walk(const Octree& tree, const UnitRay& ray, Q& query) {
    core::vec3 low, high;
    unsigned mirror = 0;
    for (int a = 0; a < 3; ++a) {
      const bool negative = ray.negative(a);
      low[a] = ray.at(a, negative ? tree.bounds.max[a] : tree.bounds.min[a]);
      high[a] = ray.at(a, negative ? tree.bounds.min[a] : tree.bounds.max[a]);
      mirror |= unsigned(negative) << a;
    }
    float entry = 0.0f;
    visit(tree, 0, low, high, mirror, entry, ray.exit, query);
  }

 private:
  /// `entry`: where the ray is. True: the search is over.
  template <class Q>
  static bool visit(const Octree& tree, std::uint32_t index, const core::vec3& low, const core::vec3& high,
                    unsigned mirror, float& entry, float end, Q& query) {
    query.visit();
    const Octree::Node& node = tree.nodes[index];
    if (node.is_leaf()) {
      const float exit = std::min({high.x, high.y, high.z});
      entry = std::max(entry, exit);
      return query.test({tree.triangles.data() + node.first, node.count}, exit) || entry >= end;
    }
    const core::vec3 middle = 0.5f * (low + high);
    unsigned octant = 0;
    for (int a = 0; a < 3; ++a) octant |= unsigned(middle[a] <= entry) << a;
    for (;;) {
      core::vec3 child_low, child_high;
      for (int a = 0; a < 3; ++a) {
        const bool upper = (octant >> a & 1u) != 0;
        child_low[a] = upper ? middle[a] : low[a];
        child_high[a] = upper ? high[a] : middle[a];
      }
      if (visit(tree, node.first + (octant ^ mirror), child_low, child_high, mirror, entry, end, query)) return true;
      const int x_or_y = child_high.x <= child_high.y ? 0 : 1;
      const int axis = child_high[x_or_y] <= child_high.z ? x_or_y : 2;
      if ((octant >> axis & 1u) != 0) return false;
      octant |= 1u << axis;
    }
  }
};

}  // namespace sightline::study::rays
