#include "sightline/apps/study/tree.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace sightline::study {
namespace {

/// Escape indices, boxes, height and leaves, from the nodes' ranges, depths and depth-first order.
void complete(std::span<const core::Aabb> boxes, Tree& tree) {
  // Depth-first: a node's subtree ends before the next node that is no deeper.
  std::vector<std::uint32_t> open;
  for (std::uint32_t i = 0; i < tree.nodes.size(); ++i) {
    while (!open.empty() && tree.nodes[open.back()].depth >= tree.nodes[i].depth) {
      tree.nodes[open.back()].escape = i;
      open.pop_back();
    }
    open.push_back(i);
    tree.height = std::max(tree.height, tree.nodes[i].depth + 1);
  }
  for (const std::uint32_t i : open) tree.nodes[i].escape = std::uint32_t(tree.nodes.size());
  for (std::uint32_t i = std::uint32_t(tree.nodes.size()); i-- > 0;) {
    TreeNode& node = tree.nodes[i];
    if (tree.leaf(i)) {
      ++tree.leaves;
      for (std::uint32_t k = node.first; k < node.end; ++k) node.box.grow(boxes[tree.order[k]]);
    } else {
      node.box = tree.nodes[i + 1].box;
      node.box.grow(tree.nodes[tree.nodes[i + 1].escape].box);
    }
  }
}

class TreeBuilder {
 public:
  TreeBuilder(std::span<const core::Aabb> boxes, std::span<const std::uint8_t> kinds, Split split,
              std::uint32_t leaf_size)
      : boxes_(boxes), kinds_(kinds), split_(split), leaf_size_(leaf_size) {}

  Tree run() {
    struct Range {
      std::uint32_t first, end, depth;
    };
    tree_.order.resize(boxes_.size());
    for (std::uint32_t i = 0; i < boxes_.size(); ++i) tree_.order[i] = i;
    std::vector<Range> stack{{0, std::uint32_t(boxes_.size()), 0}};
    while (!stack.empty()) {
      const Range r = stack.back();
      stack.pop_back();
      tree_.nodes.push_back({{}, r.first, r.end, 0, r.depth});
      if (is_leaf(r.first, r.end)) continue;
      const std::uint32_t mid = divide(r.first, r.end);
      stack.push_back({mid, r.end, r.depth + 1});
      stack.push_back({r.first, mid, r.depth + 1});
    }
    complete(boxes_, tree_);
    return std::move(tree_);
  }

 private:
  bool is_leaf(std::uint32_t first, std::uint32_t end) const {
    if (end - first <= leaf_size_) return true;
    if (kinds_.empty() || end - first > 8 * leaf_size_) return false;
    std::array<std::uint32_t, 8> counts{};
    for (std::uint32_t i = first; i < end; ++i)
      if (++counts[kinds_[tree_.order[i]] & 7u] > leaf_size_) return false;
    return true;
  }

  std::uint32_t divide(std::uint32_t first, std::uint32_t end) {
    core::Aabb box;
    for (std::uint32_t i = first; i < end; ++i) box.grow(boxes_[tree_.order[i]]);
    const core::vec3 size = box.max - box.min;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto begin = tree_.order.begin() + first, stop = tree_.order.begin() + end;
    const auto place = [&](std::uint32_t i) { return 0.5f * boxes_[i].min[axis] + 0.5f * boxes_[i].max[axis]; };
    if (split_ == Split::kMean) {
      double sum = 0.0;
      for (auto i = begin; i != stop; ++i) sum += double(place(*i));
      const double mean = sum / double(end - first);
      const auto mid = std::partition(begin, stop, [&](std::uint32_t i) { return double(place(i)) < mean; });
      if (mid != begin && mid != stop) return std::uint32_t(mid - tree_.order.begin());
    }
    const std::uint32_t mid = first + (end - first) / 2;
    std::nth_element(begin, tree_.order.begin() + mid, stop, [&](std::uint32_t a, std::uint32_t b) {
      return place(a) < place(b) || (place(a) == place(b) && a < b);
    });
    return mid;
  }

  std::span<const core::Aabb> boxes_;
  std::span<const std::uint8_t> kinds_;
  Split split_;
  std::uint32_t leaf_size_;
  Tree tree_;
};

}  // namespace

Tree build_tree(std::span<const core::Aabb> boxes, std::span<const std::uint8_t> kinds, Split split,
                std::uint32_t leaf_size) {
  assert(leaf_size > 0 && (kinds.empty() || kinds.size() == boxes.size()));
  if (boxes.empty()) return {};
  return TreeBuilder(boxes, kinds, split, leaf_size).run();
}

}  // namespace sightline::study
