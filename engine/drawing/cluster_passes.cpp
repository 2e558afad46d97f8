#include "sightline/engine/drawing/internal/cluster_passes.h"

#include <algorithm>

namespace sightline::engine {
namespace {

using culling::contains;

constexpr std::size_t kLeastClusters = 64;  // that are worth it

void insert(std::vector<std::uint64_t>& bits, std::uint32_t i) {
  bits[i / 64] |= std::uint64_t(1) << i % 64;
}

}  // namespace

void ClusterPasses::begin(const culling::OcclusionTest& test, const core::dvec3& origin, core::ThreadPool& threads) {
  test_ = &test;
  threads_ = &threads;
  boxes_.origin = origin;
  first_ = true;
  again_.clear();
  ++frame_;
}

bool ClusterPasses::filter(core::Slot slot, const lod::MeshLevels& levels, const core::Affine& world_from_mesh,
                           std::vector<std::uint32_t>& clusters) {
  if (clusters.size() < kLeastClusters && !items_.contains(slot)) return true;
  Item& item = items_[slot];
  const std::size_t words = culling::bit_words(levels.clusters.size());
  if (item.levels != &levels || item.open.size() != words) item = {&levels, {}, std::vector<std::uint64_t>(words), {}};
  if (item.frame != frame_) item.drawn.assign(words, 0);
  item.world_from_mesh = world_from_mesh;
  item.frame = frame_;
  const std::size_t all = clusters.size();
  if (first_) {
    std::erase_if(clusters, [&](std::uint32_t cluster) { return !contains(item.open, cluster); });
    if (clusters.size() < all) again_.push_back(slot);
  } else {
    std::erase_if(clusters, [&](std::uint32_t cluster) { return contains(item.drawn, cluster); });
    leave_out_hidden(item, clusters);
  }
  const bool first = std::ranges::count(item.drawn, 0u) == std::ptrdiff_t(words);
  for (const std::uint32_t cluster : clusters) insert(item.drawn, cluster);
  return first;
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

void ClusterPasses::leave_out_hidden(const Item& item, std::vector<std::uint32_t>& clusters) {
  boxes_.resize(clusters.size());
  for (std::size_t i = 0; i < clusters.size(); ++i)
    boxes_.set(i, core::round_outwards(
                      lod::placed_box(item.levels->clusters[clusters[i]].box, item.world_from_mesh, boxes_.origin),
                      core::dvec3(0.0)));
  tested_.clear();
  if (!clusters.empty()) tested_.ranges.push_back({0, core::Slot(clusters.size())});
  test_->filter(boxes_, tested_, unoccluded_, {}, threads_);
  unoccluded_bits_.assign(culling::bit_words(clusters.size()), 0);
  culling::set_bits(unoccluded_, unoccluded_bits_);
  std::uint32_t i = 0;
  std::erase_if(clusters, [&](std::uint32_t) { return !contains(unoccluded_bits_, i++); });
}

}  // namespace sightline::engine
