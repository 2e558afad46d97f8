#include "sightline/engine/drawing/internal/cluster_passes.h"

#include <algorithm>

#include "sightline/core/internal/scratch.h"

namespace sightline::engine {
namespace {

using culling::contains;

constexpr std::size_t kLeastClusters = 64;  // that are worth it

struct ClusterBuffers {
  core::ItemBounds boxes;
  core::VisibleSet tested, unoccluded;
  std::vector<std::uint64_t> bits;
  std::size_t memory_bytes() const { return core::bytes_of(boxes, tested, unoccluded, bits); }
};

void insert(std::vector<std::uint64_t>& bits, std::uint32_t i) {
  bits[i / 64] |= std::uint64_t(1) << i % 64;
}

}  // namespace

void ClusterPasses::begin(const culling::OcclusionTest& test, const core::dvec3& origin, core::ThreadPool& threads) {
  test_ = &test;
  threads_ = &threads;
  origin_ = origin;
  first_ = true;
  again_.clear();
  ++frame_;
}

bool ClusterPasses::filter(core::Slot slot, const lod::MeshLevels& levels, const core::Affine& world_from_mesh,
                           std::vector<std::uint32_t>& clusters) {
  Item* const found = find(slot, clusters.size());
  if (!found) return true;
  Item& item = *found;
  const std::size_t words = culling::bit_words(levels.clusters.size());
  if (item.levels != &levels || item.open.size() != words) item = {&levels, {}, std::vector<std::uint64_t>(words), {}};
  if (item.frame != frame_) item.drawn.assign(words, 0);
  item.world_from_mesh = world_from_mesh;
  item.frame = frame_;
  const std::size_t all = clusters.size();
  if (first_) {
    std::erase_if(clusters, [&](std::uint32_t cluster) { return !contains(item.open, cluster); });
    if (clusters.size() < all) {
      const std::lock_guard lock(*mutex_);
      again_.push_back(slot);
    }
  } else {
    std::erase_if(clusters, [&](std::uint32_t cluster) { return contains(item.drawn, cluster); });
    leave_out_hidden(item, clusters);
  }
  const bool first = std::ranges::count(item.drawn, 0u) == std::ptrdiff_t(words);
  for (const std::uint32_t cluster : clusters) insert(item.drawn, cluster);
  return first;
}

/// Null for an item that is not worth it: it has few clusters, and always had.
ClusterPasses::Item* ClusterPasses::find(core::Slot slot, std::size_t clusters) {
  const std::lock_guard lock(*mutex_);
  if (clusters < kLeastClusters && !items_.contains(slot)) return nullptr;
  return &items_[slot];
}

const std::vector<core::Slot>& ClusterPasses::begin_later_passes() {
  first_ = false;
  std::ranges::sort(again_);
  return again_;
}

void ClusterPasses::remember() {
  std::erase_if(items_, [&](const auto& entry) { return entry.second.frame != frame_; });
  for (auto& [slot, item] : items_) {
    culling::slots_of(item.drawn, kept_);
    leave_out_hidden(item, kept_);
    std::ranges::fill(item.open, 0);
    for (const std::uint32_t cluster : kept_) insert(item.open, cluster);
  }
}

void ClusterPasses::leave_out_hidden(const Item& item, std::vector<std::uint32_t>& clusters) const {
  const core::Scratch<ClusterBuffers> buffers;
  core::ItemBounds& boxes = buffers->boxes;
  boxes.origin = origin_;
  boxes.resize(clusters.size());
  for (std::size_t i = 0; i < clusters.size(); ++i)
    boxes.set(
        i, core::round_outwards(lod::placed_box(item.levels->clusters[clusters[i]].box, item.world_from_mesh, origin_),
                                core::dvec3(0.0)));
  buffers->tested.clear();
  if (!clusters.empty()) buffers->tested.ranges.push_back({0, core::Slot(clusters.size())});
  test_->filter(boxes, buffers->tested, buffers->unoccluded, {}, threads_);
  buffers->bits.assign(culling::bit_words(clusters.size()), 0);
  culling::set_bits(buffers->unoccluded, buffers->bits);
  std::uint32_t i = 0;
  std::erase_if(clusters, [&](std::uint32_t) { return !contains(buffers->bits, i++); });
}

}  // namespace sightline::engine
