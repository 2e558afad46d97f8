#include "sightline/culling/gpu/gpu_bounds.h"

#include <algorithm>
#include <cassert>

namespace sightline::culling {
namespace {

core::Expected<void> make_boxes(const gl::Functions& gl, std::uint32_t count, bool with_layers, const char* what,
                                GpuBoxes& out) {
  const auto make = [&](gl::Buffer& buffer, gl::TextureBuffer& texels, std::size_t bytes,
                        GLenum format) -> core::Expected<void> {
    auto made = gl::Buffer::create(gl, bytes, nullptr, GL_DYNAMIC_STORAGE_BIT, what);
    if (!made) return tl::unexpected(made.error());
    buffer = std::move(*made);
    auto view = gl::TextureBuffer::create(gl, buffer, format, what);
    if (!view) return tl::unexpected(view.error());
    texels = std::move(*view);
    return {};
  };
  auto done = make(out.corners, out.corner_texels, count * sizeof(core::Aabb), GL_RGB32F);
  if (done && with_layers) done = make(out.layers, out.layer_texels, count * sizeof(std::uint32_t), GL_R32UI);
  return done;
}

}  // namespace

static_assert(sizeof(core::Aabb) == 6 * sizeof(float));

core::Expected<GpuBounds> GpuBounds::create(const gl::Functions& gl, const core::ItemBounds& bounds,
                                            const gpuscene::Batch& batch, std::vector<core::Slot> slots) {
  assert(slots.size() == batch.count);
  GpuBounds made;
  made.slots_ = std::move(slots);
  made.cluster_capacity_ = (batch.capacity + kClusterSize - 1) / kClusterSize;
  auto done = make_boxes(gl, made.cluster_capacity_ * kClusterSize, bounds.uses_layers(), "item boxes", made.items_);
  if (done) done = make_boxes(gl, made.cluster_capacity_, bounds.uses_layers(), "cluster boxes", made.clusters_);
  if (!done) return tl::unexpected(done.error());
  made.write(bounds, 0, made.cluster_capacity_);
  return made;
}

std::uint32_t GpuBounds::append(core::Slot slot) {
  assert(slots_.size() < std::size_t(cluster_capacity_) * kClusterSize);
  slots_.push_back(slot);
  return std::uint32_t(slots_.size() - 1);
}

void GpuBounds::update(const core::ItemBounds& bounds, std::span<std::uint32_t> changed) const {
  // Runs of neighbouring clusters.
  for (std::size_t i = 0; i < changed.size();) {
    const std::uint32_t first = changed[i] / kClusterSize;
    std::uint32_t end = first + 1;
    for (++i; i < changed.size() && changed[i] / kClusterSize <= end; ++i) end = changed[i] / kClusterSize + 1;
    write(bounds, first, end);
  }
}

void GpuBounds::write(const core::ItemBounds& bounds, std::uint32_t first_cluster, std::uint32_t cluster_end) const {
  constexpr std::uint32_t kClustersAtOnce = 1024;
  std::vector<core::Aabb> boxes, around;
  std::vector<std::uint32_t> layers, layers_around;
  for (std::uint32_t first = first_cluster; first < cluster_end; first += kClustersAtOnce) {
    const std::uint32_t count = std::min(kClustersAtOnce, cluster_end - first);
    boxes.assign(std::size_t(count) * kClusterSize, {});
    around.assign(count, {});
    layers.assign(boxes.size(), 0);
    layers_around.assign(count, 0);
    const std::size_t begin = std::size_t(first) * kClusterSize;
    const std::size_t records = std::min(boxes.size(), slots_.size() - std::min(slots_.size(), begin));
    for (std::size_t i = 0; i < records; ++i) {
      const core::Slot slot = slots_[begin + i];
      if (bounds.vacant(slot)) continue;
      boxes[i] = bounds.box(slot);
      around[i / kClusterSize].grow(boxes[i]);
      layers[i] = bounds.layers(slot);
      layers_around[i / kClusterSize] |= layers[i];
    }
    items_.corners.write(begin * sizeof(core::Aabb), boxes.size() * sizeof(core::Aabb), boxes.data());
    clusters_.corners.write(first * sizeof(core::Aabb), around.size() * sizeof(core::Aabb), around.data());
    if (items_.layers.id() == 0) continue;
    items_.layers.write(begin * sizeof(std::uint32_t), layers.size() * sizeof(std::uint32_t), layers.data());
    clusters_.layers.write(first * sizeof(std::uint32_t), layers_around.size() * sizeof(std::uint32_t),
                           layers_around.data());
  }
}

}  // namespace sightline::culling
