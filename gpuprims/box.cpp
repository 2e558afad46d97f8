#include "sightline/gpuprims/internal/local_ray.h"
#include "sightline/gpuprims/internal/mesh_builder.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims {

Hits intersect(const core::Box& box, const Ray& ray, Caps /*caps*/) {
  Hits hits;
  const dvec3 half = 0.5 * glm::abs(dvec3(box.size_x, box.size_y, box.size_z));
  const double size = std::max(half.x, std::max(half.y, half.z));
  const int flat = (half.x == 0.0) + (half.y == 0.0) + (half.z == 0.0);
  if (flat > 1 || !std::isfinite(half.x + half.y + half.z)) return hits;
  const auto local = closest_approach(ray, weights(half), size);
  if (!local.valid) return hits;

  Span span;
  for (int axis = 0; axis < 3; ++axis) {
    const double half_extent = half[axis] * inverse_power_of_two(size);
    const int low = axis < 2 ? kMinX + 2 * axis : kBottom;
    span.clip_slab(local.origin[axis], local.direction[axis], half_extent, low, low + 1);
  }
  add_hits(hits, local, span, 0u, [](int face, const dvec3& /*p*/) {
    const bool side = face >= kMinX;
    dvec3 normal(0);
    normal[side ? (face - kMinX) / 2 : 2] = 2 * (side ? (face - kMinX) % 2 : face - kBottom) - 1;
    return normal;
  });
  return hits;
}

core::Mesh tessellate(const core::Box& box, const Tessellation& /*config*/, Caps /*caps*/) {
  const float sizes[] = {box.size_x, box.size_y, box.size_z};
  if (!all_finite(sizes)) return {};
  const dvec3 half = 0.5 * glm::abs(dvec3(box.size_x, box.size_y, box.size_z));
  MeshBuilder builder;
  for (int axis = 0; axis < 3; ++axis) {
    const int right = (axis + 1) % 3, up = (axis + 2) % 3;
    for (const double side : {-1.0, 1.0}) {
      const auto corner = [&](double x, double y) {
        dvec3 p;
        p[axis] = side * half[axis];
        p[right] = side * x * half[right];  // mirrored for the negative side, which reverses the winding
        p[up] = y * half[up];
        return p;
      };
      dvec3 normal(0.0);
      normal[axis] = side;
      const dvec3 face[] = {corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)};
      builder.add_flat_polygon(face, normal);
    }
  }
  return builder.finish();
}

}  // namespace sightline::gpuprims
