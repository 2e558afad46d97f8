#include "sightline/raytrace/internal/wide_tree.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "sightline/core/internal/openmp.h"
#include "sightline/raytrace/internal/float4.h"

namespace sightline::raytrace {
namespace {

constexpr int kBins = 16;
/// Parts of this share of all boxes are built as a whole, several at once.
constexpr std::uint32_t kJobs = 64, kSmallestJob = 4096;
/// Below this level parts are halved by number, which bounds the depth (kMostLevels).
constexpr int kDeepLevel = 20;
constexpr std::uint32_t kUnstopped = 1024;  // boxes of parts that are built without asking whether to stop

struct Box {
  Float4 low = Float4::spread(core::Aabb::kFar), high = Float4::spread(-core::Aabb::kFar);
  void grow(const Box& b) { low = least(low, b.low), high = most(high, b.high); }
  double area() const {
    float a[4];
    (high - low).store(a);
    const double x = a[0], y = a[1], z = a[2];
    return x * y + y * z + z * x;
  }
};

Box box_of(const BoxRef& ref) {
  return {Float4::load(ref.low), Float4::load(ref.high)};
}
/// Half of each corner first: a sum might overflow.
Float4 centre_of(const Box& box) {
  const Float4 half = Float4::spread(0.5f);
  return (half * box.low.three()) + (half * box.high.three());
}

struct Part {
  std::uint32_t first = 0, count = 0;
  Box box, centres;
  double area = 0.0;
  bool leaf = false;

  void grow(const Box& b) {
    const Float4 c = centre_of(b);
    box.grow(b);
    centres.grow({c, c});
  }
};

struct Split {
  double cost = 0.0;
  int axis = -1, bin = 0;  ///< bins up to `bin` go to the left
};

/// How centres become bins.
struct Binning {
  Float4 origin, scale;

  explicit Binning(const Part& part) : origin(part.centres.low) {
    float size[4];
    (part.centres.high - part.centres.low).store(size);
    for (int i = 0; i < 3; ++i) size[i] = size[i] > 1e-30f ? 0.9999f * kBins / size[i] : 0.0f;
    size[3] = 0.0f;
    scale = Float4::load(size);
  }
  void bins(const Box& box, std::int32_t out[4]) const { Float4((centre_of(box) - origin) * scale).store_whole(out); }
};

Split best_split(std::span<const BoxRef> refs, const Binning& binning, const std::stop_token& stop) {
  struct Bins {
    Box box[kBins];
    std::uint32_t count[kBins] = {};
  } axes[3];
  for (const BoxRef& ref : refs) {
    if (looks_for_stop(std::size_t(&ref - refs.data())) && stop.stop_requested()) break;
    const Box box = box_of(ref);
    alignas(16) std::int32_t bins[4];
    binning.bins(box, bins);
    for (int axis = 0; axis < 3; ++axis) {
      axes[axis].box[bins[axis]].grow(box);
      ++axes[axis].count[bins[axis]];
    }
  }
  Split best;
  for (int axis = 0; axis < 3; ++axis) {
    const Bins& bins = axes[axis];
    double right_cost[kBins];
    Box right;
    std::uint32_t count = 0;
    for (int i = kBins - 1; i > 0; --i) {
      right.grow(bins.box[i]);
      count += bins.count[i];
      right_cost[i] = count == 0 ? -1.0 : double(count) * right.area();
    }
    Box left;
    count = 0;
    for (int i = 0; i < kBins - 1; ++i) {
      left.grow(bins.box[i]);
      count += bins.count[i];
      if (count == 0 || right_cost[i + 1] < 0.0) continue;
      const double cost = double(count) * left.area() + right_cost[i + 1];
      if (best.axis < 0 || cost < best.cost) best = {cost, axis, i};
    }
  }
  return best;
}

class Builder {
 public:
  Builder(std::span<BoxRef> refs, std::uint32_t largest_leaf, const std::stop_token& stop)
      : refs_(refs), largest_leaf_(largest_leaf), stop_(stop) {}

  Part whole() const { return measured(0, std::uint32_t(refs_.size())); }

  struct Job {
    Part part;
    std::uint32_t parent;
    int level;
  };

  /// Builds the node of a part that is no leaf. Parts of at most `job_size` are left to `jobs`.
  std::uint32_t build(const Part& part, std::uint32_t parent, int level, BuiltTree& tree, std::uint32_t job_size = 0,
                      std::vector<Job>* jobs = nullptr) const {
    if (stopped(part)) return core::kNone;
    Part children[kLanes];
    const int count = split_into_children(part, level, children);
    if (stopped(part)) return core::kNone;  // a child's boxes may not hold what is in it
    const auto index = std::uint32_t(tree.nodes.size());
    tree.nodes.emplace_back();
    set_boxes(tree.nodes[index], children, count);
    tree.nodes[index].parent = parent;
    for (int lane = 0; lane < count; ++lane) {
      const Part& child = children[lane];
      const std::uint32_t place = index * kLanes + std::uint32_t(lane);
      std::uint32_t code = core::kNone;
      if (child.leaf) {
        code = kLeafBit | std::uint32_t(tree.leaves.size());
        tree.leaves.push_back({child.first, child.count});
      } else if (jobs && child.count <= job_size) {
        jobs->push_back({child, place, level + 1});
      } else {
        code = build(child, place, level + 1, tree, job_size, jobs);
      }
      tree.nodes[index].children[lane] = code;
    }
    return index;
  }

 private:
  Part measured(std::uint32_t first, std::uint32_t end) const {
    Part part;
    for (std::uint32_t i = first; i < end; ++i) {
      if (looks_for_stop(i) && stop_.stop_requested()) break;
      part.grow(box_of(refs_[i]));
    }
    finish(part, first, end);
    return part;
  }

  /// A block of triangles costs the same however many there are. So what fits in a leaf is one.
  void finish(Part& part, std::uint32_t first, std::uint32_t end) const {
    part.first = first;
    part.count = end - first;
    part.area = part.box.area();
    part.leaf = part.count <= largest_leaf_;
  }

  int split_into_children(const Part& part, int level, Part* children) const {
    const bool deep = level >= kDeepLevel;
    const auto size = [&](const Part& p) { return deep ? double(p.count) : p.area; };
    children[0] = part;
    int count = 1;
    while (count < kLanes && !stopped(part)) {
      int widest = -1;
      for (int i = 0; i < count; ++i)
        if (!children[i].leaf && (widest < 0 || size(children[i]) > size(children[widest]))) widest = i;
      if (widest < 0) break;
      Part left, right;
      split(children[widest], deep, left, right);
      children[widest] = left;
      children[count++] = right;
    }
    return count;
  }

  void split(const Part& part, bool deep, Part& left, Part& right) const {
    const auto refs = refs_.subspan(part.first, part.count);
    const Binning binning(part);
    const Split best = deep ? Split{} : best_split(refs, binning, stop_);
    if (best.axis < 0) return halve(part, left, right);
    const BoxRef* const middle = partition(refs, binning, best, left, right);
    const auto at = std::uint32_t(middle - refs_.data());
    finish(left, part.first, at);
    finish(right, at, part.first + part.count);
  }

  BoxRef* partition(std::span<BoxRef> refs, const Binning& binning, const Split& split, Part& left, Part& right) const {
    BoxRef *begin = refs.data(), *end = begin + refs.size();
    alignas(16) std::int32_t bins[4];
    while (begin < end) {
      if (looks_for_stop(std::size_t(end - begin)) && stop_.stop_requested()) break;
      const Box box = box_of(*begin);
      binning.bins(box, bins);
      if (bins[split.axis] <= split.bin) {
        left.grow(box);
        ++begin;
      } else {
        right.grow(box);
        std::swap(*begin, *--end);
      }
    }
    return begin;
  }

  /// All centres lie in one place.
  void halve(const Part& part, Part& left, Part& right) const {
    const std::uint32_t at = part.first + part.count / 2;
    left = measured(part.first, at);
    right = measured(at, part.first + part.count);
  }

  static void set_boxes(WideNode& node, const Part* children, int count) {
    for (int lane = 0; lane < kLanes; ++lane) {
      float low[4], high[4];
      const Box box = lane < count ? children[lane].box : Box{};
      box.low.store(low);
      box.high.store(high);
      for (int axis = 0; axis < 3; ++axis) {
        node.bounds[axis][lane] = low[axis];
        node.bounds[axis + 3][lane] = high[axis];
      }
      node.children[lane] = core::kNone;
    }
  }

  /// Small parts are not worth the question.
  bool stopped(const Part& part) const { return part.count > kUnstopped && stop_.stop_requested(); }

  std::span<BoxRef> refs_;
  std::uint32_t largest_leaf_;
  const std::stop_token& stop_;
};

/// Appends a tree that was built by itself, below the lane `parent`.
void append(BuiltTree& tree, const BuiltTree& part, std::uint32_t parent) {
  const auto first_node = std::uint32_t(tree.nodes.size()), first_leaf = std::uint32_t(tree.leaves.size());
  tree.nodes[parent / kLanes].children[parent % kLanes] = first_node;
  for (WideNode node : part.nodes) {
    node.parent = node.parent == core::kNone ? parent : node.parent + first_node * kLanes;
    for (std::uint32_t& child : node.children)
      if (child != core::kNone) child += (child & kLeafBit) != 0 ? first_leaf : first_node;
    tree.nodes.push_back(node);
  }
  tree.leaves.insert(tree.leaves.end(), part.leaves.begin(), part.leaves.end());
}

}  // namespace

BuiltTree build_wide_tree(std::span<BoxRef> refs, std::uint32_t largest_leaf, [[maybe_unused]] int threads,
                          std::size_t spare_nodes, const std::stop_token& stop) {
  assert(largest_leaf > 0);
  BuiltTree tree;
  const Builder builder(refs, largest_leaf, stop);
  const Part whole = builder.whole();
  if (whole.count <= largest_leaf) {
    if (whole.count > 0) tree.leaves.push_back({0, whole.count});
    return tree;
  }
  const auto job_size = std::max(whole.count / kJobs, kSmallestJob);
  std::vector<Builder::Job> jobs;
  builder.build(whole, core::kNone, 0, tree, job_size, &jobs);
  std::vector<BuiltTree> parts(jobs.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(core::team_of(threads)) if (jobs.size() > 1)
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    builder.build(jobs[i].part, core::kNone, jobs[i].level, parts[i]);
  }

  if (stop.stop_requested()) return {};
  std::size_t nodes = tree.nodes.size(), leaves = tree.leaves.size();
  for (const BuiltTree& part : parts) nodes += part.nodes.size(), leaves += part.leaves.size();
  tree.nodes.reserve(nodes + spare_nodes);
  tree.leaves.reserve(leaves);
  for (std::size_t i = 0; i < jobs.size() && !stop.stop_requested(); ++i) {
    append(tree, parts[i], jobs[i].parent);
    parts[i] = {};
  }
  return tree;
}

}  // namespace sightline::raytrace
