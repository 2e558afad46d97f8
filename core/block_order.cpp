#include "sightline/core/block_order.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>
#include <memory>
#include <numeric>

#include "sightline/core/internal/openmp.h"
#include "sightline/core/large_array.h"

namespace sightline::core {
namespace {

constexpr std::uint32_t kItemsWorthThreads = 65536;
constexpr std::uint32_t kTaskSize = 8192;  // smaller blocks are not worth a task

vec3 centroid(const Aabb& box) {
  return 0.5f * box.min + 0.5f * box.max;
}

int longest_axis(const Aabb& box) {
  const dvec3 d = dvec3(box.max) - dvec3(box.min);
  return d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
}

/// How many of `count` places go left.
std::uint32_t block_size(std::uint32_t count) {
  return std::bit_ceil(count) / 2;
}

/// Centroids move back and forth between two arrays, one level at a time; large nodes
/// are cut into chunks that threads share. What goes left is a set that the boxes determine, and it keeps its order in
/// moving, so neither threads nor chunks change the result.
class BlockOrder {
 public:
  BlockOrder(std::span<const Aabb> boxes, const BlockOrderOptions& config)
      : boxes_(boxes), config_(config), order_(boxes.size()) {
    for (auto& points : points_) points.resize_for_overwrite(boxes.size());
  }

  std::vector<std::uint32_t> run() {
    const std::uint32_t count = std::uint32_t(boxes_.size());
    [[maybe_unused]] const int threads =
        config_.threads <= 0 && count < kItemsWorthThreads ? 1 : team_of(config_.threads);
#pragma omp parallel num_threads(threads) if (threads > 1 && count > kTaskSize)
#pragma omp single
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
#pragma omp taskloop grainsize(1) default(none) shared(work) firstprivate(chunks, count)
    for (std::size_t c = 0; c < chunks; ++c) {  // clang counts in 64 bits, and would warn of narrowing
      const auto chunk = std::uint32_t(c);
      work(chunk, chunk * kChunk, std::min(count, (chunk + 1) * kChunk));
    }
  }

  // Recursion depth is at most the bit width of the count.
  void sort(std::uint32_t first, std::uint32_t count, int side) {
    Point* points = points_[side].data() + first;
    if (count <= config_.smallest_block) {
      for (std::uint32_t i = 0; i < count; ++i) order_[first + i] = points[i].index;
      return;
    }
    const std::uint32_t left_count = block_size(count), mid = first + left_count;
    if (divide(points, points_[side ^ 1].data() + first, count, left_count)) side ^= 1;
    if (left_count > kTaskSize) {
      // Only the end of the parallel region waits for it: at a taskwait a thread takes nobody else's tasks.
#pragma omp task default(none) firstprivate(first, left_count, side)
      sort(first, left_count, side);
    } else {
      sort(first, left_count, side);
    }
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
  BlockOrderOptions config_;
  LargeArray<Point> points_[2];
  std::vector<std::uint32_t> order_;
};

}  // namespace

std::vector<std::uint32_t> block_order(std::span<const Aabb> boxes, const BlockOrderOptions& config) {
  assert(config.smallest_block > 0 && boxes.size() < kNone / 2);
#ifndef NDEBUG
  for (const Aabb& b : boxes)
    for (int i = 0; i < 3; ++i) assert(b.min[i] == b.min[i] && b.max[i] == b.max[i] && "box with NaN");
#endif
  return BlockOrder(boxes, config).run();
}

}  // namespace sightline::core
