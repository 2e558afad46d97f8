#include "sightline/core/mesh_extras.h"

#include <algorithm>
#include <cmath>

namespace sightline::core {
namespace {

/// The direction from an axis to a point; any across the axis for points on it, beside it only by rounding.
dvec3 across_to(const dvec3& axis, const dvec3& away) {
  const dvec3 aside = away - glm::dot(away, axis) * axis;
  const double size = glm::length(aside);
  constexpr double kRounding = 1e-12;
  if (size > kRounding * glm::length(away)) return aside / size;
  const dvec3 other = std::abs(axis.x) < 0.5 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  return glm::normalize(glm::cross(axis, other));
}

/// In the half plane that an axis bounds: the distance from it, and the place along it.
dvec2 nearest_in_profile(const MeshSurface& surface, const dvec2& at) {
  switch (surface.kind) {
    case MeshSurface::Kind::kCylinder:
      return {surface.radius, at.y};
    case MeshSurface::Kind::kCone: {
      const dvec2 along = glm::normalize(dvec2(surface.slope, 1.0)), base(surface.radius, 0.0);
      const dvec2 on = base + along * glm::dot(at - base, along);
      return on.x >= 0.0 ? on : dvec2(0.0, -surface.radius / surface.slope);  // the apex
    }
    case MeshSurface::Kind::kTorus: {
      const dvec2 centre(surface.radius, 0.0), away = at - centre;
      const double size = glm::length(away);
      return centre + surface.tube_radius * (size > 0.0 ? away / size : dvec2(1, 0));
    }
    default:
      return at;
  }
}

}  // namespace

std::string_view name_of(MeshSurface::Kind kind) {
  constexpr std::string_view kNames[] = {"other", "plane", "cylinder", "cone", "sphere", "torus"};
  return kNames[std::size_t(kind)];
}

dvec3 nearest_point(const MeshSurface& surface, const dvec3& p) {
  const dvec3 away = p - surface.origin;
  if (surface.kind == MeshSurface::Kind::kOther) return p;
  if (surface.kind == MeshSurface::Kind::kPlane) return p - glm::dot(away, surface.axis) * surface.axis;
  if (surface.kind == MeshSurface::Kind::kSphere) {
    const double size = glm::length(away);
    return surface.origin + surface.radius * (size > 0.0 ? away / size : dvec3(0, 0, 1));
  }
  const dvec3 outwards = across_to(surface.axis, away);
  const dvec2 on = nearest_in_profile(surface, {glm::dot(away, outwards), glm::dot(away, surface.axis)});
  return surface.origin + on.x * outwards + on.y * surface.axis;
}

std::uint32_t surface_of(const Mesh& mesh, std::uint32_t triangle) {
  const auto surfaces = surfaces_stored_with(mesh);
  const auto face = std::upper_bound(surfaces.begin(), surfaces.end(), triangle,
                                     [](std::uint32_t t, const MeshSurface& s) { return t < s.end_triangle; });
  if (face == surfaces.end() || face->kind == MeshSurface::Kind::kOther || triangle >= mesh.indices.size() / 3)
    return kNone;
  for (std::size_t i = 0; i < 3; ++i) {
    const dvec3 corner(mesh.positions[mesh.indices[3 * std::size_t(triangle) + i]]);
    if (!(glm::length(nearest_point(*face, corner) - corner) <= face->gap)) return kNone;
  }
  return std::uint32_t(face - surfaces.begin());
}

MeshExtrasSlot::MeshExtrasSlot(MeshExtras extras) {
  if (extras.stored || extras.surfaces) extras_ = std::make_shared<const MeshExtras>(std::move(extras));
}

MeshExtrasSlot::MeshExtrasSlot(const MeshExtrasSlot& other) : extras_(other.extras_) {
  if (extras_ && extras_->stored) *this = MeshExtrasSlot(MeshExtras{nullptr, extras_->surfaces});
}

MeshExtrasSlot& MeshExtrasSlot::operator=(const MeshExtrasSlot& other) {
  return *this = MeshExtrasSlot(other);
}

}  // namespace sightline::core
