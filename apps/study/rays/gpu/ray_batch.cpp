#include "sightline/apps/study/rays/gpu/ray_batch.h"

#include <algorithm>
#include <array>
#include <utility>

#include "sightline/apps/study/rays/gpu/structures.h"

namespace sightline::study::rays {
namespace {

/// Ray of query.glsl, in its layout.
struct RayRecord {
  std::array<double, 4> start, towards, shear;
  std::array<float, 4> unit_origin, unit_direction, unit_inverse;
  std::array<float, 4> unused;
};
static_assert(sizeof(RayRecord) == 160 && sizeof(GpuAnswer) == 24);

constexpr std::uint32_t kRowsOfTiles = 32;  // a multiple of every tile's height

RayRecord record_of(const UnitSpace& space, const Ray& ray) {
  RayRecord record{};
  const UnitRay unit(space, ray);
  record.unit_origin = {unit.origin.x, unit.origin.y, unit.origin.z, unit.exit};
  if (unit.misses()) return record;
  const ShearedRay sheared(ray);
  const auto turned = [&](const core::dvec3& v, double fourth) {
    return std::array<double, 4>{v[sheared.x], v[sheared.y], v[sheared.z], fourth};
  };
  record.start = turned(ray.origin, ray.t_max);
  record.towards = turned(ray.direction, unit.entry);
  record.shear = {sheared.shear.x, sheared.shear.y, sheared.shear.z, unit.scale};
  record.unit_direction = {unit.direction.x, unit.direction.y, unit.direction.z, 0.0f};
  record.unit_inverse = {unit.inverse.x, unit.inverse.y, unit.inverse.z, float(sheared.z)};
  return record;
}

}  // namespace

core::Expected<RayBatch> RayBatch::create(const gl::Context& context, const TriangleSet& triangles,
                                          std::span<const Ray> rays, std::uint32_t width) {
  RayBatch batch;
  batch.width_ = width;
  const std::size_t fit = std::size_t(context.capabilities().max_storage_block_bytes) / sizeof(RayRecord);
  const std::size_t rows = std::max<std::size_t>(1, fit / width / kRowsOfTiles) * kRowsOfTiles;
  std::vector<RayRecord> records;
  for (std::size_t first = 0; first < rays.size(); first += rows * width) {
    records.clear();
    for (const Ray& ray : rays.subspan(first, std::min(rows * width, rays.size() - first)))
      records.push_back(record_of(triangles.space(), ray));
    auto uploaded = make_storage(context, records.size() * sizeof(RayRecord), records.data(), "rays");
    if (!uploaded) return tl::unexpected(uploaded.error());
    auto answers = make_storage(context, records.size() * sizeof(GpuAnswer), nullptr, "answers to rays");
    if (!answers) return tl::unexpected(answers.error());
    batch.parts_.push_back({std::move(*uploaded), std::move(*answers), std::uint32_t(records.size())});
  }
  return batch;
}

std::size_t RayBatch::size() const {
  std::size_t size = 0;
  for (const Part& part : parts_) size += part.count;
  return size;
}

std::vector<GpuAnswer> RayBatch::read() const {
  std::vector<GpuAnswer> answers(size());
  std::size_t at = 0;
  for (const Part& part : parts_) {
    part.answers.read(0, part.count * sizeof(GpuAnswer), answers.data() + at);
    at += part.count;
  }
  return answers;
}

}  // namespace sightline::study::rays
