#include "sightline/study/sah.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

namespace sightline::study {
namespace {

using core::Aabb;
using core::dvec3;
using core::vec3;

constexpr std::uint32_t kMaxBins = 64;

/// A box on its way through the build, moved rather than looked up: the partition is bound by memory.
struct Reference {
  Aabb box;
  std::uint32_t index;
};

vec3 centroid(const Aabb& box) {
  return 0.5f * box.min + 0.5f * box.max;
}

/// Bounds of boxes and of their centroids.
struct Extent {
  Aabb boxes, centroids;
  void grow(const Aabb& box) {
    const vec3 c = centroid(box);
    boxes.grow(box);
    centroids.grow({c, c});
  }
  void grow(const Extent& e) {
    boxes.grow(e.boxes);
    centroids.grow(e.centroids);
  }
};

/// Half the surface, in double: squares of 1e38 and of denormals stay finite and positive.
double half_area(const Aabb& box) {
  if (box.empty()) return 0.0;
  const dvec3 d = dvec3(box.max) - dvec3(box.min);
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

struct Halves {
  std::uint32_t mid = 0;  // 0: none found
  Extent left, right;
};

int longest_axis(const Aabb& box) {
  const dvec3 d = dvec3(box.max) - dvec3(box.min);
  return d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
}

/// Copies sparse nodes in pre-order, the two children of a node side by side.
void compact(const std::vector<SahNode>& sparse, SahTree& tree) {
  struct Entry {
    std::uint32_t target, depth;
    std::size_t source;
  };
  std::vector<Entry> stack{{0, 0, 0}};
  tree.nodes.resize(1);
  while (!stack.empty()) {
    const Entry e = stack.back();
    stack.pop_back();
    SahNode node = sparse[e.source];
    tree.depth = std::max(tree.depth, e.depth);
    if (!node.leaf()) {
      const std::uint32_t left = std::uint32_t(tree.nodes.size());
      tree.nodes.resize(tree.nodes.size() + 2);
      stack.push_back({left + 1, e.depth + 1, std::size_t(node.left) + 1});
      stack.push_back({left, e.depth + 1, node.left});
      node.left = left;
    }
    tree.nodes[e.target] = node;
  }
  tree.nodes.shrink_to_fit();
}

class SahBuilder {
 public:
  SahBuilder(std::span<const Aabb> boxes, const SahConfig& config) : config_(config), references_(boxes.size()) {
    const std::uint32_t levels = std::uint32_t(std::bit_width(boxes.size()));
    depth_limit_ = 2 * levels + 30;
    for (std::uint32_t i = 0; i < boxes.size(); ++i) references_[i] = {boxes[i], i};
    sparse_.resize(2 * boxes.size());
  }

  SahTree run() {
    SahTree tree;
    if (references_.empty()) return tree;
    Extent all;
    for (const Reference& r : references_) all.grow(r.box);
    build(0, 0, std::uint32_t(references_.size()), all, 0);
    compact(sparse_, tree);
    tree.order.resize(references_.size());
    for (std::size_t i = 0; i < references_.size(); ++i) tree.order[i] = references_[i].index;
    return tree;
  }

 private:
  // Recursion depth is at most depth_limit_.
  void build(std::size_t node, std::uint32_t first, std::uint32_t count, const Extent& extent, std::uint32_t depth) {
    if (count <= config_.max_leaf_size) {
      sparse_[node] = {first, count, 0};
      return;
    }
    const std::uint32_t levels_needed = std::uint32_t(std::bit_width(count));
    Halves split;
    if (depth + levels_needed < depth_limit_) split = binned_split(first, count, extent);
    if (split.mid == 0) split = halve(first, count, extent);
    // Each split position occurs once in the tree, so 2 mid - 1 and 2 mid are places that no other node's children
    // take.
    const std::size_t left = 2 * std::size_t(split.mid) - 1;
    sparse_[node] = {first, count, std::uint32_t(left)};
    const std::uint32_t left_count = split.mid - first, right_count = count - left_count;
    build(left, first, left_count, split.left, depth + 1);
    build(left + 1, split.mid, right_count, split.right, depth + 1);
  }

  Halves binned_split(std::uint32_t first, std::uint32_t count, const Extent& extent) {
    const int axis = longest_axis(extent.centroids);
    const double low = extent.centroids.min[axis];
    const double range = double(extent.centroids.max[axis]) - low;
    if (!(range > 0.0)) return {};
    const std::uint32_t bins = std::clamp(config_.bins, 2u, kMaxBins);
    const double scale = double(bins) / range;
    const auto bin_of = [&](const Aabb& box) {
      const double c = 0.5f * box.min[axis] + 0.5f * box.max[axis];
      return std::min(bins - 1, std::uint32_t(std::max(0.0, (c - low) * scale)));
    };

    std::array<Extent, kMaxBins> extents;
    std::array<std::uint32_t, kMaxBins> counts{};
    for (std::uint32_t i = first; i < first + count; ++i) {
      const std::uint32_t bin = bin_of(references_[i].box);
      extents[bin].grow(references_[i].box);
      ++counts[bin];
    }
    const std::uint32_t boundary = cheapest_boundary(extents, counts, bins);
    if (boundary == 0) return {};

    Halves split;
    for (std::uint32_t b = 0; b < bins; ++b) (b < boundary ? split.left : split.right).grow(extents[b]);
    const auto begin = references_.begin() + first;
    const auto mid = std::partition(begin, begin + count, [&](const Reference& r) { return bin_of(r.box) < boundary; });
    split.mid = std::uint32_t(mid - references_.begin());
    return split;
  }

  /// First bin of the right side, 0 when every boundary leaves one side empty.
  std::uint32_t cheapest_boundary(const std::array<Extent, kMaxBins>& extents,
                                  const std::array<std::uint32_t, kMaxBins>& counts, std::uint32_t bins) const {
    const double group = config_.group;
    const auto cost = [group](const Aabb& box, std::uint32_t n) { return half_area(box) * std::ceil(n / group); };
    std::array<double, kMaxBins> left_cost{};
    Aabb box;
    std::uint32_t n = 0;
    for (std::uint32_t b = 0; b + 1 < bins; ++b) {
      box.grow(extents[b].boxes);
      n += counts[b];
      left_cost[b + 1] = n == 0 ? std::numeric_limits<double>::infinity() : cost(box, n);
    }
    std::uint32_t best = 0;
    double best_cost = std::numeric_limits<double>::infinity();
    box = {};
    n = 0;
    for (std::uint32_t b = bins - 1; b > 0; --b) {
      box.grow(extents[b].boxes);
      n += counts[b];
      const double total = left_cost[b] + cost(box, n);
      if (n > 0 && total < best_cost) {
        best_cost = total;
        best = b;
      }
    }
    return best;
  }

  Halves halve(std::uint32_t first, std::uint32_t count, const Extent& extent) {
    Halves split;
    split.mid = first + count / 2;
    const int axis = longest_axis(extent.centroids);
    if (extent.centroids.max[axis] > extent.centroids.min[axis]) {
      const auto begin = references_.begin() + first;
      std::nth_element(begin, begin + count / 2, begin + count, [axis](const Reference& a, const Reference& b) {
        const float ca = centroid(a.box)[axis], cb = centroid(b.box)[axis];
        return ca < cb || (ca == cb && a.index < b.index);
      });
    }
    for (std::uint32_t i = first; i < first + count; ++i)
      (i < split.mid ? split.left : split.right).grow(references_[i].box);
    return split;
  }

  SahConfig config_;
  std::vector<Reference> references_;
  std::vector<SahNode> sparse_;  // 2 n places of which the tree uses some
  std::uint32_t depth_limit_ = 0;
};

}  // namespace

SahTree build_sah(std::span<const Aabb> boxes, const SahConfig& config) {
  assert(config.max_leaf_size > 0 && config.group > 0 && boxes.size() < core::kNone / 2);
  return SahBuilder(boxes, config).run();
}

}  // namespace sightline::study
