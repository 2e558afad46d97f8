#include "sightline/culling/gpu/internal/gpu_bounds.h"

#include <algorithm>
#include <cassert>
#include <numeric>

#include "sightline/core/internal/snapshot_prefetch.h"
#include "sightline/core/internal/store.h"

namespace sightline::culling {
namespace {

using core::Aabb;
using gpuscene::ElementWriter;

/// The record at a place among those of `clusters`, kItemsPerCluster each.
std::size_t record_at(std::span<const std::uint32_t> clusters, std::size_t place) {
  return std::size_t(clusters[place / kItemsPerCluster]) * kItemsPerCluster + place % kItemsPerCluster;
}

/// The clusters of some records. `records` is sorted.
std::vector<std::uint32_t> clusters_of(std::span<const std::uint32_t> records) {
  std::vector<std::uint32_t> clusters;
  for (const std::uint32_t record : records)
    if (clusters.empty() || clusters.back() != record / kItemsPerCluster) clusters.push_back(record / kItemsPerCluster);
  return clusters;
}

}  // namespace

static_assert(sizeof(Aabb) == 6 * sizeof(float));

core::Expected<GpuBounds> GpuBounds::create(const gl::Functions& gl, const core::Snapshot& snapshot,
                                            const gpuscene::Batch& batch, std::vector<core::Slot> slots) {
  assert(slots.size() == batch.count);
  GpuBounds made;
  made.slots_ = std::move(slots);
  made.cluster_capacity_ = (batch.capacity + kItemsPerCluster - 1) / kItemsPerCluster;
  const std::size_t clusters = made.cluster_capacity_, items = clusters * kItemsPerCluster;
  const auto make = [&](gl::TexelArray& out, std::size_t bytes, GLenum format, const char* what) {
    return core::store(gl::TexelArray::create(gl, bytes, nullptr, format, what), out);
  };
  auto done = make(made.item_boxes_, items * sizeof(Aabb), GL_RGB32F, "item boxes");
  if (done) done = make(made.cluster_boxes_, clusters * sizeof(Aabb), GL_RGB32F, "cluster boxes");
  if (snapshot.bounds().uses_layers()) {
    if (done) done = make(made.item_layers_, items * sizeof(std::uint32_t), GL_R32UI, "item layers");
    if (done) done = make(made.cluster_layers_, clusters * sizeof(std::uint32_t), GL_R32UI, "cluster layers");
  }
  if (!done) return tl::unexpected(done.error());
  made.around_.resize(clusters);
  if (snapshot.bounds().uses_layers()) made.layers_around_.resize(clusters);
  std::vector<std::uint32_t> all(made.cluster_capacity_);
  std::iota(all.begin(), all.end(), 0u);
  ElementWriter writer;  // of neighbours alone
  made.write(snapshot, all, writer, {});
  return made;
}

std::uint32_t GpuBounds::append(core::Slot slot) {
  assert(slots_.size() < std::size_t(cluster_capacity_) * kItemsPerCluster);
  slots_.push_back(slot);
  return std::uint32_t(slots_.size() - 1);
}

void GpuBounds::update(const core::Snapshot& snapshot, std::span<const std::uint32_t> changed, ElementWriter& writer,
                       SlotBits left_out) {
  write(snapshot, clusters_of(changed), writer, left_out);
}

void GpuBounds::update_shown(const core::Snapshot& snapshot, std::span<const std::uint32_t> changed,
                             ElementWriter& writer, SlotBits left_out) {
  const core::ItemBounds& bounds = snapshot.bounds();
  std::vector<Aabb> boxes(changed.size());
  std::vector<std::uint32_t> layers(changed.size(), 0);
  for (std::size_t i = 0; i < changed.size(); ++i) {
    if (i + core::kPrefetchAhead < changed.size())
      core::prefetch_box(snapshot, slots_[changed[i + core::kPrefetchAhead]]);
    const core::Slot slot = slots_[changed[i]];
    if (bounds.vacant(slot) || contains(left_out, slot)) continue;
    boxes[i] = bounds.box(slot);
    layers[i] = bounds.layers(slot);
    around_[changed[i] / kItemsPerCluster].grow(boxes[i]);
    if (!layers_around_.empty()) layers_around_[changed[i] / kItemsPerCluster] |= layers[i];
  }
  writer.write(item_boxes_.buffer, sizeof(Aabb), changed, boxes.data());
  if (!layers_around_.empty()) writer.write(item_layers_.buffer, sizeof(std::uint32_t), changed, layers.data());
  write_clusters(clusters_of(changed), writer);
}

void GpuBounds::write(const core::Snapshot& snapshot, Clusters clusters, ElementWriter& writer, SlotBits left_out) {
  constexpr std::size_t kClustersAtOnce = 1024;
  for (std::size_t first = 0; first < clusters.size(); first += kClustersAtOnce)
    write_part(snapshot, clusters.subspan(first, std::min(kClustersAtOnce, clusters.size() - first)), writer, left_out);
}

void GpuBounds::write_part(const core::Snapshot& snapshot, Clusters clusters, ElementWriter& writer,
                           SlotBits left_out) {
  const core::ItemBounds& bounds = snapshot.bounds();
  std::vector<Aabb> boxes(clusters.size() * kItemsPerCluster);
  std::vector<std::uint32_t> layers(boxes.size(), 0);
  for (const std::uint32_t cluster : clusters) {
    around_[cluster] = {};
    if (!layers_around_.empty()) layers_around_[cluster] = 0;
  }
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const std::size_t record = record_at(clusters, i);
    if (record >= slots_.size() || bounds.vacant(slots_[record]) || contains(left_out, slots_[record])) continue;
    const core::Slot slot = slots_[record];
    boxes[i] = bounds.box(slot);
    layers[i] = bounds.layers(slot);
    around_[record / kItemsPerCluster].grow(boxes[i]);
    if (!layers_around_.empty()) layers_around_[record / kItemsPerCluster] |= layers[i];
  }
  writer.write(item_boxes_.buffer, kItemsPerCluster * sizeof(Aabb), clusters, boxes.data());
  if (!layers_around_.empty())
    writer.write(item_layers_.buffer, kItemsPerCluster * sizeof(std::uint32_t), clusters, layers.data());
  write_clusters(clusters, writer);
}

void GpuBounds::write_clusters(Clusters clusters, ElementWriter& writer) const {
  std::vector<Aabb> boxes;
  for (const std::uint32_t cluster : clusters) boxes.push_back(around_[cluster]);
  writer.write(cluster_boxes_.buffer, sizeof(Aabb), clusters, boxes.data());
  if (layers_around_.empty()) return;
  std::vector<std::uint32_t> layers;
  for (const std::uint32_t cluster : clusters) layers.push_back(layers_around_[cluster]);
  writer.write(cluster_layers_.buffer, sizeof(std::uint32_t), clusters, layers.data());
}

}  // namespace sightline::culling
