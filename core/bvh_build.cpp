#include "sightline/core/internal/bvh_build.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <limits>
#include <memory>
#include <numeric>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace sightline::core {
namespace {

constexpr std::uint32_t kMaxBins = 64;
[[maybe_unused]] constexpr std::uint32_t kTaskSize = 8192;  // smaller subtrees are not worth a task
constexpr double kGroup = 8.0;  // leaves are tested this many boxes at a time, so the cost counts groups

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

struct Split {
  std::uint32_t mid = 0;  // 0: none found
  Extent left, right;
};

int longest_axis(const Aabb& box) {
  const dvec3 d = dvec3(box.max) - dvec3(box.min);
  return d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
}

/// Copies sparse nodes in pre-order, the two children of a node side by side.
void compact(const std::vector<BvhNode>& sparse, BvhTree& tree) {
  struct Entry {
    std::uint32_t target, depth;
    std::size_t source;
  };
  std::vector<Entry> stack{{0, 0, 0}};
  tree.nodes.resize(1);
  while (!stack.empty()) {
    const Entry e = stack.back();
    stack.pop_back();
    BvhNode node = sparse[e.source];
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

#ifdef _OPENMP
int thread_count(const BvhConfig& config) {
  return config.threads > 0 ? config.threads : omp_get_max_threads();
}
#endif

/// BvhSplit::kBlocks: how many of `count` places go left.
std::uint32_t block_size(std::uint32_t count) {
  return std::bit_ceil(count) / 2;
}

/// The nodes of BvhSplit::kBlocks, which follow from the number of boxes alone.
void add_block_nodes(std::uint32_t count, std::uint32_t max_leaf_size, BvhTree& tree) {
  if (count == 0) return;
  tree.nodes.push_back({0, count, 0});
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    const BvhNode node = tree.nodes[n];
    if (node.count <= max_leaf_size) continue;
    const std::uint32_t left_count = block_size(node.count);
    tree.nodes[n].left = std::uint32_t(tree.nodes.size());
    tree.nodes.push_back({node.first, left_count, 0});
    tree.nodes.push_back({node.first + left_count, node.count - left_count, 0});
  }
  // No way down is longer than the leftmost: its nodes are the largest of their level.
  for (std::uint32_t n = count; n > max_leaf_size; n = block_size(n)) ++tree.depth;
}

/// The order of BvhSplit::kBlocks. Centroids move back and forth between two arrays, one level at a time; large nodes
/// are cut into chunks that threads share. What goes left is a set that the boxes determine, and it keeps its order in
/// moving, so neither threads nor chunks change the result.
class BlockOrder {
 public:
  BlockOrder(std::span<const Aabb> boxes, const BvhConfig& config)
      : boxes_(boxes),
        config_(config),
        // Not zeroed: the threads that fill them take the page faults.
        points_{std::make_unique_for_overwrite<Point[]>(boxes.size()),
                std::make_unique_for_overwrite<Point[]>(boxes.size())},
        order_(boxes.size()) {}

  std::vector<std::uint32_t> run() {
    const std::uint32_t count = std::uint32_t(boxes_.size());
#ifdef _OPENMP
    const int threads = thread_count(config_);
#pragma omp parallel num_threads(threads) if (threads > 1 && count > kTaskSize)
#pragma omp single
#endif
    {
      // The whole of space has no centroid: it gathers at the origin.
      const auto number = [](float x) { return x == x ? x : 0.0f; };
      for_chunks(count, [&](std::uint32_t, std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t i = begin; i < end; ++i) {
          const vec3 c = centroid(boxes_[i]);
          points_[0][i] = {{number(c.x), number(c.y), number(c.z)}, i};
        }
      });
      sort(0, count, 0);
    }
    return std::move(order_);
  }

 private:
  struct Point {
    float at[3];
    std::uint32_t index;
  };
  static constexpr std::uint32_t kMaxBuckets = 1024, kSmall = 96, kChunk = 16384;

  /// What a thread finds out about its part of a node.
  struct Chunk {
    Aabb extent;
    std::uint32_t counts[kMaxBuckets + 1];
    Point *left, *middle, *right;  // where its points go
  };

  static std::uint32_t chunk_count(std::uint32_t count) {
    return (count + kChunk - 1) / kChunk;
  }

  /// work(chunk, begin, end) for all chunks of 0 … count.
  template <class Work>
  static void for_chunks(std::uint32_t count, const Work& work) {
    const std::uint32_t chunks = chunk_count(count);
    if (chunks <= 1) return work(0, 0, count);
#ifdef _OPENMP
#pragma omp taskloop grainsize(1) default(none) shared(work) firstprivate(chunks, count)
#endif
    for (std::size_t c = 0; c < chunks; ++c) {  // clang counts in 64 bits, and would warn of narrowing
      const auto chunk = std::uint32_t(c);
      work(chunk, chunk * kChunk, std::min(count, (chunk + 1) * kChunk));
    }
  }

  // Recursion depth is at most the bit width of the count.
  void sort(std::uint32_t first, std::uint32_t count, int side) {
    Point* points = points_[side].get() + first;
    if (count <= config_.max_leaf_size) {
      for (std::uint32_t i = 0; i < count; ++i) order_[first + i] = points[i].index;
      return;
    }
    const std::uint32_t left_count = block_size(count), mid = first + left_count;
    if (divide(points, points_[side ^ 1].get() + first, count, left_count)) side ^= 1;
#ifdef _OPENMP
    if (left_count > kTaskSize) {
      // Only the end of the parallel region waits for it: at a taskwait a thread takes nobody else's tasks.
#pragma omp task default(none) firstprivate(first, left_count, side)
      sort(first, left_count, side);
    } else
#endif
      sort(first, left_count, side);
    sort(mid, count - left_count, side);
  }

  static Aabb extent_of(std::span<const Point> points) {
    Aabb extent;
    for (const Point& p : points) {
      for (int a = 0; a < 3; ++a) {
        extent.min[a] = p.at[a] < extent.min[a] ? p.at[a] : extent.min[a];
        extent.max[a] = p.at[a] > extent.max[a] ? p.at[a] : extent.max[a];
      }
    }
    return extent;
  }

  /// Brings the `left_count` points that come first along the longest axis to the front, ties by index. True when the
  /// result is in `target`.
  static bool divide(Point* points, Point* target, std::uint32_t count, std::uint32_t left_count) {
    const std::uint32_t chunk_total = chunk_count(count);
    Chunk only;
    const auto several = chunk_total > 1 ? std::make_unique_for_overwrite<Chunk[]>(chunk_total) : nullptr;
    const std::span<Chunk> chunks = several ? std::span(several.get(), chunk_total) : std::span(&only, 1);

    for_chunks(count, [&](std::uint32_t c, std::uint32_t begin, std::uint32_t end) {
      chunks[c].extent = extent_of({points + begin, points + end});
    });
    Aabb extent;
    for (const Chunk& chunk : chunks) extent.grow(chunk.extent);
    const int axis = longest_axis(extent);
    const auto less = [axis](const Point& a, const Point& b) {
      return a.at[axis] < b.at[axis] || (a.at[axis] == b.at[axis] && a.index < b.index);
    };
    const std::uint32_t buckets = std::min(kMaxBuckets, std::bit_ceil(count) / 4);
    const float low = extent.min[axis], scale = float(buckets) / (extent.max[axis] - low);
    if (!(scale > 0.0f && scale <= std::numeric_limits<float>::max()) || count <= kSmall) {
      std::nth_element(points, points + left_count, points + count, less);
      return false;
    }
    // Rounding is monotone: a smaller coordinate never has a higher bucket, and none lies above `buckets`.
    const auto bucket_of = [=](const Point& p) { return (p.at[axis] - low) * scale; };
    const Middle m = scatter(chunks, {points, count}, target, left_count, buckets, bucket_of);
    if (left_count < m.first + m.count)
      std::nth_element(target + m.first, target + left_count, target + m.first + m.count, less);
    return true;
  }

  /// Where the points of the bucket went that holds the last of the left side.
  struct Middle {
    std::uint32_t first, count;
  };

  /// Sorts points into those of lower buckets, of the middle one, and of higher ones, each in their old order.
  /// bucket_of: 0 … buckets, with a fraction.
  template <class BucketOf>
  static Middle scatter(std::span<Chunk> chunks, std::span<const Point> points, Point* target, std::uint32_t left_count,
                        std::uint32_t buckets, const BucketOf& bucket_of) {
    const std::uint32_t count = std::uint32_t(points.size());
    for_chunks(count, [&](std::uint32_t c, std::uint32_t begin, std::uint32_t end) {
      std::uint32_t* const counts = chunks[c].counts;
      std::fill_n(counts, buckets + 1, 0u);
      for (std::uint32_t i = begin; i < end; ++i) ++counts[int(bucket_of(points[i]))];
    });
    int middle = 0;
    Middle found{0, 0};
    for (;; ++middle, found.first += found.count) {
      found.count = 0;
      for (const Chunk& chunk : chunks) found.count += chunk.counts[middle];
      if (found.first + found.count >= left_count) break;
    }

    Point *left = target, *among = target + found.first, *right = among + found.count;
    for (std::uint32_t c = 0; c < chunks.size(); ++c) {
      Chunk& chunk = chunks[c];
      chunk.left = left, chunk.middle = among, chunk.right = right;
      const std::uint32_t lower = std::accumulate(chunk.counts, chunk.counts + middle, 0u);
      left += lower;
      among += chunk.counts[middle];
      right += std::min(kChunk, count - c * kChunk) - lower - chunk.counts[middle];
    }
    const float from = float(middle), to = float(middle + 1);
    for_chunks(count, [&](std::uint32_t c, std::uint32_t begin, std::uint32_t end) {
      Point *l = chunks[c].left, *m = chunks[c].middle, *r = chunks[c].right;
      // Without branches: sides are as random as it gets.
      for (std::uint32_t i = begin; i < end; ++i) {
        const float bucket = bucket_of(points[i]);
        const bool lower = bucket < from, higher = bucket >= to;
        Point* place = lower ? l : m;
        place = higher ? r : place;
        *place = points[i];
        l += lower;
        m += !(lower || higher);
        r += higher;
      }
    });
    return found;
  }

  std::span<const Aabb> boxes_;
  BvhConfig config_;
  std::unique_ptr<Point[]> points_[2];
  std::vector<std::uint32_t> order_;
};

/// BvhSplit::kSurface.
class Builder {
 public:
  Builder(std::span<const Aabb> boxes, const BvhConfig& config) : config_(config), references_(boxes.size()) {
    const std::uint32_t levels = std::uint32_t(std::bit_width(boxes.size()));
    depth_limit_ = 2 * levels + 30;
    for (std::uint32_t i = 0; i < boxes.size(); ++i) references_[i] = {boxes[i], i};
    sparse_.resize(2 * boxes.size());
  }

  BvhTree run() {
    BvhTree tree;
    if (references_.empty()) return tree;
    Extent all;
    for (const Reference& r : references_) all.grow(r.box);
    build_in_parallel(all);
    compact(sparse_, tree);
    tree.order.resize(references_.size());
    for (std::size_t i = 0; i < references_.size(); ++i) tree.order[i] = references_[i].index;
    return tree;
  }

 private:
  void build_in_parallel(const Extent& all) {
    const std::uint32_t count = std::uint32_t(references_.size());
#ifdef _OPENMP
    const int threads = thread_count(config_);
    if (threads > 1 && count > kTaskSize) {
#pragma omp parallel num_threads(threads)
#pragma omp single
      build(0, 0, count, all, 0);
      return;
    }
#endif
    build(0, 0, count, all, 0);
  }

  // Recursion depth is at most depth_limit_.
  void build(std::size_t node, std::uint32_t first, std::uint32_t count, const Extent& extent, std::uint32_t depth) {
    if (count <= config_.max_leaf_size) {
      sparse_[node] = {first, count, 0};
      return;
    }
    const std::uint32_t levels_needed = std::uint32_t(std::bit_width(count));
    Split split;
    if (depth + levels_needed < depth_limit_) split = binned_split(first, count, extent);
    if (split.mid == 0) split = halve(first, count, extent);
    // Each split position occurs once in the tree, so 2 mid - 1 and 2 mid are places of its children that no other task
    // uses.
    const std::size_t left = 2 * std::size_t(split.mid) - 1;
    sparse_[node] = {first, count, std::uint32_t(left)};
    const std::uint32_t left_count = split.mid - first, right_count = count - left_count;
#ifdef _OPENMP
    if (count > kTaskSize) {
#pragma omp task default(none) firstprivate(left, first, left_count, split, depth)
      build(left, first, left_count, split.left, depth + 1);
      build(left + 1, split.mid, right_count, split.right, depth + 1);
      return;
    }
#endif
    build(left, first, left_count, split.left, depth + 1);
    build(left + 1, split.mid, right_count, split.right, depth + 1);
  }

  Split binned_split(std::uint32_t first, std::uint32_t count, const Extent& extent) {
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

    Split split;
    for (std::uint32_t b = 0; b < bins; ++b) (b < boundary ? split.left : split.right).grow(extents[b]);
    const auto begin = references_.begin() + first;
    const auto mid = std::partition(begin, begin + count, [&](const Reference& r) { return bin_of(r.box) < boundary; });
    split.mid = std::uint32_t(mid - references_.begin());
    return split;
  }

  /// First bin of the right side, 0 when every boundary leaves one side empty.
  static std::uint32_t cheapest_boundary(const std::array<Extent, kMaxBins>& extents,
                                         const std::array<std::uint32_t, kMaxBins>& counts, std::uint32_t bins) {
    const auto cost = [](const Aabb& box, std::uint32_t n) { return half_area(box) * std::ceil(n / kGroup); };
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

  Split halve(std::uint32_t first, std::uint32_t count, const Extent& extent) {
    Split split;
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

  BvhConfig config_;
  std::vector<Reference> references_;
  std::vector<BvhNode> sparse_;  // 2 n places of which the tree uses some
  std::uint32_t depth_limit_ = 0;
};

}  // namespace

BvhTree build_bvh(std::span<const Aabb> boxes, const BvhConfig& config) {
  assert(config.max_leaf_size > 0 && boxes.size() < kNone / 2);
#ifndef NDEBUG
  for (const Aabb& b : boxes)
    for (int i = 0; i < 3; ++i) assert(b.min[i] == b.min[i] && b.max[i] == b.max[i] && "box with NaN");
#endif
  if (config.split == BvhSplit::kSurface) return Builder(boxes, config).run();
  BvhTree tree;
  tree.order = BlockOrder(boxes, config).run();
  add_block_nodes(std::uint32_t(boxes.size()), config.max_leaf_size, tree);
  return tree;
}

}  // namespace sightline::core
