#include "sightline/apps/study/rays/kd_tree.h"

#include <algorithm>
#include <limits>

namespace sightline::study::rays {
namespace {

using core::Aabb;
using core::vec3;

constexpr std::uint32_t kMaxBins = 32;

using References = std::vector<Reference>;

struct Split {
  float cost = std::numeric_limits<float>::infinity();
  float position = 0.0f;
  int axis = -1;  // -1: none
};

/// Planes across one axis of a node, and how many boxes lie below and above each.
class Bins {
 public:
  /// The planes span `tight`, the box around all references: the outermost cut off empty space.
  Bins(const Aabb& box, const Aabb& tight, int axis, std::uint32_t bins, const GridLines* lines) : axis_(axis) {
    const float low = tight.min[axis], size = tight.max[axis] - low;
    for (std::uint32_t b = 0; b <= bins; ++b) {
      float plane = low + size * (float(b) / float(bins));
      if (lines != nullptr)
        plane = lines->line(axis, std::int32_t(std::lround((plane - lines->low[axis]) * lines->per_cell[axis])));
      if (plane > box.min[axis] && plane < box.max[axis] && (count_ == 0 || plane > planes_[count_ - 1]))
        planes_[count_++] = plane;
    }
    if (count_ > 1) per_plane_ = float(count_ - 1) / (planes_[count_ - 1] - planes_[0]);
  }

  void add(const Aabb& box) {
    ++below_[first_above(box.min[axis_], false)];
    ++above_[first_above(box.max[axis_], true)];
  }

  /// `cost` of (plane, boxes below, boxes above), called at every plane in order.
  template <class Cost>
  void for_each_plane(std::uint32_t total, const Cost& cost) const {
    std::uint32_t left = 0, right = total;
    for (std::uint32_t b = 0; b < count_; ++b) {
      left += below_[b];
      right -= above_[b];
      cost(planes_[b], left, right);
    }
  }

 private:
  /// The first plane above x, or at x as well. Planes are close to equally spaced: a guess, corrected.
  std::uint32_t first_above(float x, bool or_at) const {
    const auto above = [&](std::uint32_t b) { return or_at ? planes_[b] >= x : planes_[b] > x; };
    if (count_ == 0) return 0;
    std::uint32_t b = std::uint32_t(std::clamp((x - planes_[0]) * per_plane_, 0.0f, float(count_ - 1)));
    while (b < count_ && !above(b)) ++b;
    while (b > 0 && above(b - 1)) --b;
    return b;
  }

  int axis_;
  std::uint32_t count_ = 0;
  float per_plane_ = 0.0f;
  std::array<float, kMaxBins + 1> planes_;
  std::array<std::uint32_t, kMaxBins + 2> below_{}, above_{};  // by the first plane above
};

class KdBuilder {
 public:
  KdBuilder(KdTree& tree, const KdConfig& config, std::size_t count) : tree_(tree), config_(config) {
    depth_limit_ = std::min(KdTree::kMaxDepth, 8 + std::uint32_t(1.3 * double(std::bit_width(count))));
  }

  void build(std::uint32_t node, References references, const Aabb& box, std::uint32_t depth) {
    const Split split = depth < depth_limit_ ? cheapest_split(references, box) : Split{};
    if (!(split.cost < config_.intersection_cost * float(references.size()))) return make_leaf(node, references);
    const std::uint32_t left = std::uint32_t(tree_.nodes.size());
    tree_.nodes[node] = KdNode::inner(split.axis, split.position, left);
    tree_.nodes.resize(tree_.nodes.size() + 2);
    References below, above;
    for (const Reference& r : references) {
      if (r.box.min[split.axis] < split.position) below.push_back(r), cut(below.back().box.max, split);
      if (r.box.max[split.axis] > split.position) above.push_back(r), raise(above.back().box.min, split);
    }
    References().swap(references);
    Aabb low = box, high = box;
    low.max[split.axis] = high.min[split.axis] = split.position;
    build(left, std::move(below), low, depth + 1);
    build(left + 1, std::move(above), high, depth + 1);
  }

 private:
  static void cut(vec3& max, const Split& s) { max[s.axis] = std::min(max[s.axis], s.position); }
  static void raise(vec3& min, const Split& s) { min[s.axis] = std::max(min[s.axis], s.position); }

  void make_leaf(std::uint32_t node, const References& references) {
    tree_.nodes[node] = KdNode::leaf(std::uint32_t(tree_.triangles.size()), std::uint32_t(references.size()));
    for (const Reference& r : references) tree_.triangles.push_back(r.triangle);
  }

  Split cheapest_split(const References& references, const Aabb& box) const {
    Split best;
    if (references.empty()) return best;
    Aabb tight;
    for (const Reference& r : references) tight.grow(r.box);
    const std::uint32_t total = std::uint32_t(references.size());
    const std::uint32_t bins = std::min({config_.bins, kMaxBins, 4 + 2 * total});
    for (int axis = 0; axis < 3; ++axis) {
      Bins planes(box, tight, axis, bins, config_.lines);
      for (const Reference& r : references) planes.add(r.box);
      planes.for_each_plane(total, [&](float plane, std::uint32_t left, std::uint32_t right) {
        Aabb low = box, high = box;
        low.max[axis] = high.min[axis] = plane;
        float cost = config_.traversal_cost + config_.intersection_cost *
                                                  (float(left) * half_area(low) + float(right) * half_area(high)) /
                                                  half_area(box);
        if (left == 0 || right == 0) cost *= config_.empty_factor;
        if (cost < best.cost) best = {cost, plane, axis};
      });
    }
    return best;
  }

  KdTree& tree_;
  const KdConfig& config_;
  std::uint32_t depth_limit_;
};

/// Calls visit(node, box) for every node, parents first.
template <class Visit>
void for_each_box(const KdTree& tree, const Visit& visit) {
  const auto walk = [&](const auto& self, std::uint32_t node, const Aabb& box) -> void {
    visit(node, box);
    const KdNode& n = tree.nodes[node];
    if (n.is_leaf()) return;
    Aabb low = box, high = box;
    low.max[n.axis()] = high.min[n.axis()] = n.split();
    self(self, n.left(), low);
    self(self, n.left() + 1, high);
  };
  walk(walk, 0, tree.bounds);
}

/// Hands each node the ropes of its box, and each leaf its record.
class RopeBuilder {
 public:
  explicit RopeBuilder(KdTreeWithRopes& result) : result_(result), nodes_(result.tree.nodes) {}

  void build(std::uint32_t node, const Aabb& box, std::array<std::uint32_t, 6> ropes) {
    for (int face = 0; face < 6; ++face) ropes[std::size_t(face)] = push_down(ropes[std::size_t(face)], box, face);
    const KdNode& n = nodes_[node];
    if (n.is_leaf()) {
      result_.nodes[node] = KdNode::leaf(std::uint32_t(result_.leaves.size()), 0);
      result_.leaves.push_back({box, ropes, n.first(), n.count()});
      return;
    }
    const std::size_t axis = std::size_t(n.axis());
    Aabb low = box, high = box;
    low.max[n.axis()] = high.min[n.axis()] = n.split();
    auto low_ropes = ropes, high_ropes = ropes;
    low_ropes[axis + 3] = n.left() + 1;
    high_ropes[axis] = n.left();
    build(n.left(), low, low_ropes);
    build(n.left() + 1, high, high_ropes);
  }

 private:
  /// The smallest subtree behind the face that is as large as the face.
  std::uint32_t push_down(std::uint32_t rope, const Aabb& box, int face) const {
    while (rope != core::kNone && !nodes_[rope].is_leaf()) {
      const KdNode& n = nodes_[rope];
      if (n.axis() == face % 3)
        rope = n.left() + (face < 3 ? 1u : 0u);
      else if (n.split() <= box.min[n.axis()])
        rope = n.left() + 1;
      else if (n.split() >= box.max[n.axis()])
        rope = n.left();
      else
        break;
    }
    return rope;
  }

  KdTreeWithRopes& result_;
  const std::vector<KdNode>& nodes_;
};

}  // namespace

KdTree build_kd_tree(std::span<const Aabb> boxes, const Aabb& bounds, const KdConfig& config) {
  KdTree tree;
  tree.bounds = bounds;
  tree.nodes.resize(1);
  References references(boxes.size());
  for (std::uint32_t i = 0; i < boxes.size(); ++i) references[i] = {boxes[i], i};
  KdBuilder(tree, config, boxes.size()).build(0, std::move(references), bounds, 0);
  tree.nodes.shrink_to_fit();
  tree.triangles.shrink_to_fit();
  return tree;
}

std::vector<Aabb> node_boxes(const KdTree& tree) {
  std::vector<Aabb> boxes(tree.nodes.size());
  for_each_box(tree, [&](std::uint32_t node, const Aabb& box) { boxes[node] = box; });
  return boxes;
}

KdTreeWithParents::KdTreeWithParents(const KdTree& kd) : tree(kd), parents(kd.nodes.size()), boxes(node_boxes(kd)) {
  for (std::uint32_t i = 0; i < kd.nodes.size(); ++i)
    if (const KdNode& n = kd.nodes[i]; !n.is_leaf()) parents[n.left()] = parents[n.left() + 1] = i;
}

KdTreeWithRopes::KdTreeWithRopes(const KdTree& kd) : tree(kd), nodes(kd.nodes) {
  std::array<std::uint32_t, 6> outside;
  outside.fill(core::kNone);
  RopeBuilder(*this).build(0, kd.bounds, outside);
  leaves.shrink_to_fit();
}

}  // namespace sightline::study::rays
