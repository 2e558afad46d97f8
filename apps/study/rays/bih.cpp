#include "sightline/apps/study/rays/bih.h"

#include <algorithm>
#include <cassert>
#include <numeric>

namespace sightline::study::rays {
namespace {

using core::Aabb;

class BihBuilder {
 public:
  BihBuilder(Bih& bih, std::span<const Aabb> boxes, std::uint32_t leaf_size)
      : bih_(bih), boxes_(boxes), leaf_size_(leaf_size) {}

  void build(std::uint32_t node, std::uint32_t first, std::uint32_t end, Aabb space, std::uint32_t depth) {
    if (end - first <= leaf_size_) {
      bih_.nodes[node] = Bih::Node::leaf(first, end - first);
      return;
    }
    const auto begin = bih_.triangles.begin();
    std::uint32_t middle = first;
    int axis = 0;
    Aabb low, high;
    // Halves that hold nothing are cut off without a node.
    while (depth < kSpatialDepth && (middle == first || middle == end)) {
      axis = longest_axis(space);
      const float plane = 0.5f * (space.min[axis] + space.max[axis]);
      low = high = space;
      low.max[axis] = high.min[axis] = plane;
      const auto below = [&](std::uint32_t t) { return boxes_[t].min[axis] + boxes_[t].max[axis] < 2.0f * plane; };
      middle = std::uint32_t(std::partition(begin + first, begin + end, below) - begin);
      space = middle == first ? high : low;
      ++depth;
    }
    if (middle == first || middle == end) {
      middle = first + (end - first) / 2;
      low = high = space;
    }
    const std::uint32_t left = std::uint32_t(bih_.nodes.size());
    bih_.nodes.resize(left + 2);
    float left_end = -1.0f, right_begin = 2.0f;
    for (std::uint32_t i = first; i < middle; ++i) left_end = std::max(left_end, boxes_[bih_.triangles[i]].max[axis]);
    for (std::uint32_t i = middle; i < end; ++i)
      right_begin = std::min(right_begin, boxes_[bih_.triangles[i]].min[axis]);
    bih_.nodes[node] = Bih::Node::inner(axis, left, left_end, right_begin);
    build(left, first, middle, low, depth);
    build(left + 1, middle, end, high, depth);
  }

 private:
  static constexpr std::uint32_t kSpatialDepth = 60;  // halving by number needs at most 32 levels more

  Bih& bih_;
  std::span<const Aabb> boxes_;
  std::uint32_t leaf_size_;
};

}  // namespace

Bih build_bih(std::span<const Aabb> boxes, const Aabb& bounds, std::uint32_t leaf_size) {
  assert(leaf_size > 0);
  Bih bih;
  bih.nodes.resize(1);
  bih.triangles.resize(boxes.size());
  std::iota(bih.triangles.begin(), bih.triangles.end(), 0u);
  BihBuilder(bih, boxes, leaf_size).build(0, 0, std::uint32_t(boxes.size()), bounds, 0);
  bih.nodes.shrink_to_fit();
  return bih;
}

}  // namespace sightline::study::rays
