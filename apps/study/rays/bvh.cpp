#include "sightline/apps/study/rays/bvh.h"

namespace sightline::study::rays {
namespace {

using core::Aabb;
using core::vec3;

constexpr std::size_t kBins = 16;
constexpr std::uint32_t kBinnedDepth = 60;  // halving by number needs at most 32 levels more
static_assert(kBinnedDepth + 32 < Bvh::kMaxDepth);

vec3 centroid(const Aabb& box) {
  return 0.5f * box.min + 0.5f * box.max;
}

struct Bin {
  Aabb box;
  std::uint32_t count = 0;
  void add(const Bin& other) {
    box.grow(other.box);
    count += other.count;
  }
  float cost() const { return count == 0 ? 0.0f : half_area(box) * float(count); }
};

/// The first bin of the right side where the surface-area heuristic costs least; 0 where every boundary leaves one
/// side empty.
std::size_t cheapest_boundary(const std::array<Bin, kBins>& bins) {
  std::array<Bin, kBins + 1> right;  // by the first bin of the right side
  for (std::size_t b = kBins; b-- > 0;) {
    right[b] = right[b + 1];
    right[b].add(bins[b]);
  }
  Bin left;
  std::size_t best = 0;
  float best_cost = std::numeric_limits<float>::infinity();
  for (std::size_t b = 1; b < kBins; ++b) {
    left.add(bins[b - 1]);
    const float cost = left.cost() + right[b].cost();
    if (left.count > 0 && right[b].count > 0 && cost < best_cost) best = b, best_cost = cost;
  }
  return best;
}

/// Orders the references, which are moved rather than looked up since the partition is bound by memory, so that the
/// left child's come first, and returns their number.
std::size_t divide(std::span<Reference> references, const Aabb& centroids, bool binned) {
  const int axis = longest_axis(centroids);
  const float size = centroids.max[axis] - centroids.min[axis];
  if (binned && size > 0.0f) {
    const float scale = float(kBins) / size;
    const auto bin_of = [&](const Reference& r) {
      return std::min(kBins - 1, std::size_t((centroid(r.box)[axis] - centroids.min[axis]) * scale));
    };
    std::array<Bin, kBins> bins;
    for (const Reference& r : references) bins[bin_of(r)].add({r.box, 1});
    if (const std::size_t boundary = cheapest_boundary(bins); boundary > 0) {
      const auto below = [&](const Reference& r) { return bin_of(r) < boundary; };
      return std::size_t(std::partition(references.begin(), references.end(), below) - references.begin());
    }
  }
  const auto middle = references.begin() + std::ptrdiff_t(references.size() / 2);
  std::nth_element(references.begin(), middle, references.end(), [axis](const Reference& a, const Reference& b) {
    const float ca = centroid(a.box)[axis], cb = centroid(b.box)[axis];
    return ca < cb || (ca == cb && a.triangle < b.triangle);
  });
  return references.size() / 2;
}

void build_node(Bvh& bvh, std::uint32_t node, std::span<Reference> references, std::uint32_t leaf_size,
                std::uint32_t depth) {
  Aabb box, centroids;
  for (const Reference& r : references) {
    box.grow(r.box);
    centroids.grow({centroid(r.box), centroid(r.box)});
  }
  if (references.size() <= leaf_size) {
    bvh.nodes[node] = {box, std::uint32_t(bvh.triangles.size()), std::uint32_t(references.size())};
    for (const Reference& r : references) bvh.triangles.push_back(r.triangle);
    return;
  }
  const std::size_t middle = divide(references, centroids, depth < kBinnedDepth);
  const std::uint32_t left = std::uint32_t(bvh.nodes.size());
  bvh.nodes[node] = {box, left, 0};
  bvh.nodes.resize(left + 2);
  build_node(bvh, left, references.first(middle), leaf_size, depth + 1);
  build_node(bvh, left + 1, references.subspan(middle), leaf_size, depth + 1);
}

}  // namespace

Bvh build_bvh(std::span<const Aabb> boxes, std::uint32_t leaf_size) {
  Bvh bvh;
  if (boxes.empty()) return bvh;
  std::vector<Reference> references;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) references.push_back({boxes[i], i});
  bvh.nodes.resize(1);
  build_node(bvh, 0, references, leaf_size, 0);
  bvh.nodes.shrink_to_fit();
  return bvh;
}

}  // namespace sightline::study::rays
