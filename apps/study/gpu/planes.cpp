#include "sightline/apps/study/gpu/planes.h"

#include <algorithm>
#include <array>

#include "sightline/culling/gpu/internal/gpu_band.h"

namespace sightline::study {
namespace {

/// StudyPlanes (std140).
struct PlaneBlock {
  std::array<float, 4> planes[culling::kMaxCullPlanes];
  std::int32_t count, unused[3];
};

float within_range(double x) {
  return core::round_up(std::min(x, double(core::Aabb::kFar)));
}

}  // namespace

core::Expected<GpuPlanes> GpuPlanes::create(const gl::Functions& gl) {
  auto block = gl::Buffer::create(gl, sizeof(PlaneBlock), nullptr, GL_DYNAMIC_STORAGE_BIT, "study planes");
  if (!block) return tl::unexpected(block.error());
  GpuPlanes planes;
  planes.gl_ = &gl;
  planes.block_ = std::move(*block);
  return planes;
}

void GpuPlanes::upload(const culling::CullPlanes& planes, const core::ItemBounds& bounds) const {
  PlaneBlock block{};
  block.count = planes.union_first();
  for (int k = 0; k < block.count; ++k) {
    const culling::FloatPlane& p = planes.planes()[k];
    const double band = culling::gpu_band(p.band, bounds);
    block.planes[k] = {p.normal[0], p.normal[1], p.normal[2], within_range(double(p.offset) + band)};
  }
  block_.write(0, sizeof(block), &block);
  gl_->BindBufferBase(GL_UNIFORM_BUFFER, kPlaneBinding, block_.id());
}

core::ItemBounds extent_of(std::span<const core::Aabb> boxes) {
  core::Aabb extent;
  for (const core::Aabb& box : boxes)
    if (!box.empty()) extent.grow(box);
  core::ItemBounds bounds;
  bounds.resize(1);
  bounds.set(0, extent);
  return bounds;
}

}  // namespace sightline::study
