#include "sightline/study/rays/bvh.h"

#include <cassert>

#include "sightline/study/sah.h"

namespace sightline::study::rays {

Bvh build_bvh(std::span<const core::Aabb> boxes, std::uint32_t leaf_size) {
  SahTree tree = build_sah(boxes, {.max_leaf_size = leaf_size, .group = 1});
  assert(tree.depth < Bvh::kMaxDepth);
  Bvh bvh;
  bvh.nodes.resize(tree.nodes.size());
  for (std::size_t i = tree.nodes.size(); i-- > 0;) {  // children come after their parents
    const SahNode& node = tree.nodes[i];
    Bvh::Node& made = bvh.nodes[i];
    if (node.leaf()) {
      made.first = node.first, made.count = node.count;
      for (std::uint32_t k = 0; k < node.count; ++k) made.box.grow(boxes[tree.order[node.first + k]]);
    } else {
      made.first = node.left;
      made.box.grow(bvh.nodes[node.left].box);
      made.box.grow(bvh.nodes[node.left + 1].box);
    }
  }
  bvh.triangles = std::move(tree.order);
  return bvh;
}

}  // namespace sightline::study::rays
