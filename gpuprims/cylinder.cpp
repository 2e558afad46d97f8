#include <cmath>
#include <numbers>
#include <vector>

#include "sightline/gpuprims/internal/local_ray.h"
#include "sightline/gpuprims/internal/mesh_builder.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims {
Hits intersect(const core::Cylinder& cylinder, const Ray& ray, Caps caps) {
  Hits hits;
  const double radius = std::fabs(cylinder.radius), half = 0.5 * std::fabs(cylinder.height);
  if (!(radius > 0.0 && std::isfinite(radius + half))) return hits;
  const auto local = closest_approach(ray, {1.0, 1.0, weight(radius, half)}, radius);
  if (!local.valid) return hits;
  const double per_unit = inverse_power_of_two(radius);
  auto span = cylinder_span(local.origin, local.direction, radius * per_unit, kSide);
  span.clip_slab(local.origin.z, local.direction.z, half * per_unit, kBottom, kTop);
  add_hits(hits, local, span, internal_faces(caps), [](int face, const dvec3& p) {
    constexpr double kAcross[] = {1, 0, 0}, kAlong[] = {0, -1, 1};  // indexed by face
    return dvec3(kAcross[face] * p.x, kAcross[face] * p.y, kAlong[face]);
  });
  return hits;
}

core::Mesh tessellate(const core::Cylinder& cylinder, const Tessellation& config, Caps caps) {
  const double radius = std::fabs(cylinder.radius), half = 0.5 * std::fabs(cylinder.height);
  if (!(radius > 0.0 && std::isfinite(radius + half))) return {};
  const int segments = segment_count(config, radius, 2.0 * std::numbers::pi);
  const std::vector<dvec2> circle = arc_points(segments, 2.0 * std::numbers::pi);

  MeshBuilder builder;
  builder.add_grid(1, segments, [&](int row, int column) {
    return Vertex{dvec3(radius * circle[column], row == 0 ? -half : half), dvec3(circle[column], 0.0)};
  });
  if (caps.top) builder.add_disc(circle, radius, half, 1.0);
  if (caps.bottom) builder.add_disc(circle, radius, -half, -1.0);
  return builder.finish();
}

}  // namespace sightline::gpuprims
