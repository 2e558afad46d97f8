#include "sightline/raytrace/internal/surface.h"

#include <algorithm>
#include <cmath>

namespace sightline::raytrace {
namespace {

using core::dvec3;

/// The linear part for normals. Cofactors are defined for singular placements, too.
core::dmat3 cofactors(const core::dmat3& m) {
  return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

/// The mean of the corners' normals at a point of a triangle, in the world; its sign and length say nothing.
dvec3 smooth_normal(const core::Mesh& mesh, const core::Affine& world_from_item, const Hit& hit) {
  const std::uint32_t* corner = mesh.indices.data() + 3 * std::size_t(hit.triangle);
  const auto at = [&](int i) { return core::transform_point(world_from_item, dvec3(mesh.positions[corner[i]])); };
  const dvec3 a = at(0) - hit.point, b = at(1) - hit.point, c = at(2) - hit.point;
  const double area[] = {glm::dot(glm::cross(b, c), hit.normal), glm::dot(glm::cross(c, a), hit.normal),
                         glm::dot(glm::cross(a, b), hit.normal)};
  dvec3 sum(0.0);
  for (int i = 0; i < 3; ++i) {
    const dvec3 normal(mesh.normals[corner[i]]);
    const double length = glm::length(normal);
    if (length > 0.0 && std::isfinite(length)) sum += area[i] / length * normal;
  }
  return cofactors(world_from_item.linear) * sum;
}

}  // namespace

dvec3 shading_normal(const core::Snapshot& snapshot, const Hit& hit, const dvec3& direction) {
  dvec3 normal = hit.normal;
  if (hit.triangle != core::kNone && !snapshot.mesh(hit.slot).normals.empty()) {
    const dvec3 n = smooth_normal(snapshot.mesh(hit.slot), snapshot.world_from_item(hit.slot), hit);
    const double length = glm::length(n);
    normal = length > 0.0 && std::isfinite(length) ? n / length : -direction;
  }
  return glm::dot(normal, direction) > 0.0 ? -normal : normal;
}

glm::vec4 material_of(const core::Snapshot& snapshot, core::Slot slot) {
  const std::uint32_t material = snapshot.material(slot);
  return material != core::kNone ? snapshot.materials()[material]
                                 : glm::vec4(core::Material().colour, core::Material().alpha);
}

bool all_opaque(const core::MaterialTable& materials) {
  return std::all_of(materials.begin(), materials.end(), [](const glm::vec4& row) { return row.a >= 1.0f; });
}

}  // namespace sightline::raytrace
