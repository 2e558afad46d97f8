#include "sightline/apps/study/rays/octree.h"

#include <array>
#include <bit>

namespace sightline::study::rays {
namespace {

using core::Aabb;

bool overlap(const Aabb& a, const Aabb& b) {
  return glm::all(glm::lessThanEqual(a.min, b.max)) && glm::all(glm::lessThanEqual(b.min, a.max));
}

Aabb octant_of(const Aabb& box, unsigned octant) {
  const core::vec3 middle = 0.5f * (box.min + box.max);
  Aabb child = box;
  for (int a = 0; a < 3; ++a) ((octant >> a & 1u) != 0 ? child.min : child.max)[a] = middle[a];
  return child;
}

class OctreeBuilder {
 public:
  OctreeBuilder(Octree& tree, std::span<const Aabb> boxes, std::uint32_t leaf_size)
      : tree_(tree),
        boxes_(boxes),
        leaf_size_(leaf_size),
        depth_limit_(std::uint32_t(std::bit_width(boxes.size())) / 2) {}

  void build(std::uint32_t node, std::vector<std::uint32_t> triangles, const Aabb& box, std::uint32_t depth) {
    if (triangles.size() <= leaf_size_ || depth == depth_limit_) return make_leaf(node, triangles);
    std::array<std::vector<std::uint32_t>, 8> inside;
    std::size_t references = 0;
    for (unsigned octant = 0; octant < 8; ++octant) {
      const Aabb child = octant_of(box, octant);
      for (const std::uint32_t t : triangles)
        if (overlap(boxes_[t], child)) inside[octant].push_back(t);
      references += inside[octant].size();
    }
    if (references == 8 * triangles.size()) return make_leaf(node, triangles);  // separates nothing
    std::vector<std::uint32_t>().swap(triangles);
    const std::uint32_t first = std::uint32_t(tree_.nodes.size());
    tree_.nodes[node] = {first, Octree::Node::kInner};
    tree_.nodes.resize(tree_.nodes.size() + 8);
    for (unsigned octant = 0; octant < 8; ++octant)
      build(first + octant, std::move(inside[octant]), octant_of(box, octant), depth + 1);
  }

 private:
  void make_leaf(std::uint32_t node, const std::vector<std::uint32_t>& triangles) {
    tree_.nodes[node] = {std::uint32_t(tree_.triangles.size()), std::uint32_t(triangles.size())};
    tree_.triangles.insert(tree_.triangles.end(), triangles.begin(), triangles.end());
  }

  Octree& tree_;
  std::span<const Aabb> boxes_;
  std::uint32_t leaf_size_, depth_limit_;
};

}  // namespace

Octree build_octree(std::span<const Aabb> boxes, const Aabb& bounds, std::uint32_t leaf_size) {
  Octree tree;
  tree.bounds = bounds;
  tree.nodes.resize(1);
  std::vector<std::uint32_t> all(boxes.size());
  for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  OctreeBuilder(tree, boxes, leaf_size).build(0, std::move(all), bounds, 0);
  tree.nodes.shrink_to_fit();
  tree.triangles.shrink_to_fit();
  return tree;
}

}  // namespace sightline::study::rays
