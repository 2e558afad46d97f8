#include "sightline/culling/gpu/gpu_bounds.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <numeric>

#include "sightline/culling/gpu/compact_box.h"
#include "sightline/culling/gpu/record_box.h"

namespace sightline::culling {
namespace {

using core::Aabb;
using gpuscene::BatchKind;
using gpuscene::ElementWriter;

/// What shaders/item_test.glsl reads of a cluster whose boxes come from records.
struct ClusterBits {
  std::uint32_t present[2] = {0, 0}, from_record[2] = {0, 0};
};

core::Expected<void> make_array(const gl::Functions& gl, std::size_t bytes, GLenum format, const char* what,
                                TexelArray& out) {
  auto made = TexelArray::create(gl, bytes, nullptr, format, what);
  if (!made) return tl::unexpected(made.error());
  out = std::move(*made);
  return {};
}

/// The record at a place among those of `clusters`, kClusterSize each.
std::size_t record_at(std::span<const std::uint32_t> clusters, std::size_t place) {
  return std::size_t(clusters[place / kClusterSize]) * kClusterSize + place % kClusterSize;
}

}  // namespace

static_assert(sizeof(Aabb) == 6 * sizeof(float));
static_assert(sizeof(CompactBox) == 8 && sizeof(ClusterBits) == 16);

core::Expected<TexelArray> TexelArray::create(const gl::Functions& gl, std::size_t bytes, const void* data,
                                              GLenum format, const char* what) {
  auto buffer = gl::Buffer::create(gl, bytes, data, GL_DYNAMIC_STORAGE_BIT, what);
  if (!buffer) return tl::unexpected(buffer.error());
  auto texels = gl::TextureBuffer::create(gl, *buffer, format, what);
  if (!texels) return tl::unexpected(texels.error());
  return TexelArray{std::move(*buffer), std::move(*texels)};
}

core::vec3 chunk_place(const core::Snapshot& snapshot, std::uint32_t chunk) {
  return core::vec3(snapshot.chunk_origins()[chunk] - snapshot.bounds().origin);
}

GpuBoundsForm GpuBounds::form_for(BatchKind kind, GpuBoundsForm form) {
  const bool shaped = is_ray_cast(kind) || kind == BatchKind::kBox;
  return form == GpuBoundsForm::kParameters && !shaped ? GpuBoundsForm::kCompact : form;
}

core::Expected<GpuBounds> GpuBounds::create(const gl::Functions& gl, const core::Snapshot& snapshot,
                                            const gpuscene::Batch& batch, std::vector<core::Slot> slots,
                                            GpuBoundsForm form) {
  assert(slots.size() == batch.count);
  GpuBounds made;
  made.slots_ = std::move(slots);
  made.kind_ = batch.kind;
  made.form_ = form;
  made.texels_per_item_ = batch.texels_per_item;
  made.cluster_capacity_ = (batch.capacity + kClusterSize - 1) / kClusterSize;
  const std::size_t clusters = made.cluster_capacity_, items = clusters * kClusterSize;
  core::Expected<void> done;
  switch (form) {
    case GpuBoundsForm::kFloat:
      done = make_array(gl, items * sizeof(Aabb), GL_RGB32F, "item boxes", made.item_boxes_);
      break;
    case GpuBoundsForm::kCompact:
      done = make_array(gl, items * sizeof(CompactBox), GL_RG32UI, "compact item boxes", made.item_boxes_);
      break;
    case GpuBoundsForm::kParameters:
      done = make_array(gl, clusters * sizeof(ClusterBits), GL_RGBA32UI, "items present", made.item_boxes_);
      break;
  }
  if (done) done = make_array(gl, clusters * sizeof(Aabb), GL_RGB32F, "cluster boxes", made.cluster_boxes_);
  if (snapshot.bounds().uses_layers()) {
    if (done) done = make_array(gl, items * sizeof(std::uint32_t), GL_R32UI, "item layers", made.item_layers_);
    if (done) done = make_array(gl, clusters * sizeof(std::uint32_t), GL_R32UI, "cluster layers", made.cluster_layers_);
  }
  if (!done) return tl::unexpected(done.error());
  std::vector<std::uint32_t> all(made.cluster_capacity_);
  std::iota(all.begin(), all.end(), 0u);
  ElementWriter writer;  // of neighbours alone
  made.write(snapshot, all, writer);
  return made;
}

std::uint32_t GpuBounds::append(core::Slot slot) {
  assert(slots_.size() < std::size_t(cluster_capacity_) * kClusterSize);
  slots_.push_back(slot);
  return std::uint32_t(slots_.size() - 1);
}

void GpuBounds::update(const core::Snapshot& snapshot, std::span<const std::uint32_t> changed,
                       ElementWriter& writer) const {
  std::vector<std::uint32_t> clusters;
  for (const std::uint32_t record : changed)
    if (clusters.empty() || clusters.back() != record / kClusterSize) clusters.push_back(record / kClusterSize);
  write(snapshot, clusters, writer);
}

void GpuBounds::write(const core::Snapshot& snapshot, Clusters clusters, ElementWriter& writer) const {
  constexpr std::size_t kClustersAtOnce = 1024;
  for (std::size_t first = 0; first < clusters.size(); first += kClustersAtOnce)
    write_part(snapshot, clusters.subspan(first, std::min(kClustersAtOnce, clusters.size() - first)), writer);
}

void GpuBounds::write_part(const core::Snapshot& snapshot, Clusters clusters, ElementWriter& writer) const {
  const core::ItemBounds& bounds = snapshot.bounds();
  std::vector<Aabb> boxes(clusters.size() * kClusterSize), around(clusters.size());
  std::vector<std::uint32_t> layers(boxes.size(), 0), layers_around(clusters.size(), 0);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const std::size_t record = record_at(clusters, i);
    if (record >= slots_.size() || bounds.vacant(slots_[record])) continue;
    const core::Slot slot = slots_[record];
    boxes[i] = bounds.box(slot);
    around[i / kClusterSize].grow(boxes[i]);
    layers[i] = bounds.layers(slot);
    layers_around[i / kClusterSize] |= layers[i];
  }
  write_items(snapshot, clusters, boxes, around, writer);
  writer.write(cluster_boxes_.buffer, sizeof(Aabb), clusters, around.data());
  if (item_layers_.buffer.id() == 0) return;
  writer.write(item_layers_.buffer, kClusterSize * sizeof(std::uint32_t), clusters, layers.data());
  writer.write(cluster_layers_.buffer, sizeof(std::uint32_t), clusters, layers_around.data());
}

/// `boxes` of the clusters' items, empty ones where there is none.
void GpuBounds::write_items(const core::Snapshot& snapshot, Clusters clusters, std::span<const Aabb> boxes,
                            std::span<const Aabb> around, ElementWriter& writer) const {
  if (form_ == GpuBoundsForm::kFloat) {
    writer.write(item_boxes_.buffer, kClusterSize * sizeof(Aabb), clusters, boxes.data());
  } else if (form_ == GpuBoundsForm::kCompact) {
    std::vector<CompactBox> compacted(boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i)
      compacted[i] = boxes[i].min.x > boxes[i].max.x ? CompactBox{CompactBox::kVacant, 0}
                                                     : compact(boxes[i], around[i / kClusterSize]);
    writer.write(item_boxes_.buffer, kClusterSize * sizeof(CompactBox), clusters, compacted.data());
  } else {
    std::vector<ClusterBits> bits(around.size());
    std::array<gpuprims::Texel, gpuscene::kMostTexelsPerItem> record;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      if (boxes[i].min.x > boxes[i].max.x) continue;
      const auto texels = std::span(record).first(std::size_t(texels_per_item_));
      gpuscene::GpuScene::pack(snapshot, slots_[record_at(clusters, i)], texels);
      const std::size_t word = i / 32 % 2;
      const std::uint32_t bit = 1u << (i % 32);
      ClusterBits& cluster = bits[i / kClusterSize];
      cluster.present[word] |= bit;
      if (record_box_contains(kind_, texels, chunk_place(snapshot, texels[3][0]), boxes[i]))
        cluster.from_record[word] |= bit;
    }
    writer.write(item_boxes_.buffer, sizeof(ClusterBits), clusters, bits.data());
  }
}

}  // namespace sightline::culling
