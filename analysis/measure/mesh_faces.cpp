#include "sightline/analysis/measure/internal/mesh_faces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

namespace sightline::measure {
namespace {

using SurfaceKind = core::MeshSurface::Kind;

/// The factor by which a placement scales all lengths, or nothing where it scales them unequally.
std::optional<double> uniform_scale(const dmat3& m) {
  constexpr double kUnequal = 1e-6;  // more than single-precision placements make of equal lengths
  const double size = glm::length(m[0]);
  if (!(size > 0.0)) return std::nullopt;
  for (int i = 0; i < 3; ++i) {
    if (std::fabs(glm::length(m[i]) - size) > kUnequal * size) return std::nullopt;
    if (std::fabs(glm::dot(m[i], m[(i + 1) % 3])) > kUnequal * size * size) return std::nullopt;
  }
  return std::cbrt(std::fabs(glm::determinant(m)));
}

dvec3 unit_or_zero(const dvec3& v) {
  const double size = glm::length(v);
  return size > 0.0 ? v / size : dvec3(0.0);
}

/// A surface in the world, or one of no kind where it is none that is known.
core::MeshSurface placed(core::MeshSurface surface, const core::Affine& place, std::optional<double> scale) {
  const dmat3& m = place.linear;
  surface.origin = core::transform_point(place, surface.origin);
  if (surface.kind == SurfaceKind::kPlane) {
    const dmat3 normals{glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
    surface.axis = unit_or_zero(normals * surface.axis);
  } else if (!scale) {
    surface.kind = SurfaceKind::kOther;
  } else {
    surface.axis = unit_or_zero(m * surface.axis);
    surface.radius *= *scale, surface.tube_radius *= *scale, surface.gap *= *scale;
  }
  if (surface.axis == dvec3(0.0) && surface.kind != SurfaceKind::kSphere) surface.kind = SurfaceKind::kOther;
  return surface;
}

/// From where to where a face reaches along its axis.
struct Extent {
  double from = std::numeric_limits<double>::infinity(), to = -std::numeric_limits<double>::infinity();
  void grow(double at) { from = std::min(from, at), to = std::max(to, at); }
};

void add_straight(const Extent& extent, std::string_view end_words, MeshFace& face) {
  const core::MeshSurface& s = face.surface;
  const core::Kind of = core::Kind::kMesh;
  const dvec3 from = s.origin + extent.from * s.axis, to = s.origin + extent.to * s.axis;
  face.features.push_back({FeatureKind::kAxis, of, face_words(s.kind), Segment{from, to}});
  for (const dvec3& end : {from, to}) face.features.push_back({FeatureKind::kCentre, of, end_words, end});
}

void add_round(MeshFace& face) {
  const core::MeshSurface& s = face.surface;
  face.features.push_back({FeatureKind::kCentre, core::Kind::kMesh, face_words(s.kind), s.origin});
  if (s.kind != SurfaceKind::kTorus) return;
  const dvec3 u =
      s.radius * glm::normalize(glm::cross(s.axis, std::fabs(s.axis.x) < 0.5 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  face.features.push_back(
      {FeatureKind::kAxis, core::Kind::kMesh, face_words(s.kind), Arc{s.origin, u, glm::cross(s.axis, u)}});
}

void complete(const Extent& extent, MeshFace& face) {
  const core::MeshSurface& s = face.surface;
  std::vector<Dimension>& d = face.dimensions;
  switch (s.kind) {
    case SurfaceKind::kCylinder:
      d = {{"diameter", 2.0 * s.radius}, {"radius", s.radius}, {"length", extent.to - extent.from}};
      return add_straight(extent, "an end of a cylindrical face", face);
    case SurfaceKind::kCone: {
      const auto [least, most] =
          std::minmax({std::max(0.0, s.radius + s.slope * extent.from), std::max(0.0, s.radius + s.slope * extent.to)});
      d = {{"half angle", std::atan(std::fabs(s.slope)), true},
           {"largest diameter", 2.0 * most},
           {"smallest diameter", 2.0 * least},
           {"length", extent.to - extent.from}};
      return add_straight(extent, "an end of a conical face", face);
    }
    case SurfaceKind::kSphere:
      d = {{"diameter", 2.0 * s.radius}, {"radius", s.radius}};
      return add_round(face);
    case SurfaceKind::kTorus:
      d = {{"bend radius", s.radius}, {"tube diameter", 2.0 * s.tube_radius}, {"tube radius", s.tube_radius}};
      return add_round(face);
    default:
      return;
  }
}

}  // namespace

std::string_view face_words(SurfaceKind kind) {
  constexpr std::string_view kWords[] = {
      "", "a plane face", "a cylindrical face", "a conical face", "a spherical face", "a toroidal face"};
  return kWords[std::size_t(kind)];
}

MeshFaces find_mesh_faces(const core::Mesh& mesh, const core::Affine& world_from_item, const Shape& shape) {
  MeshFaces found;
  const auto surfaces = core::surfaces_stored_with(mesh);
  if (surfaces.empty()) return found;
  const std::optional<double> scale = uniform_scale(world_from_item.linear);
  std::map<std::uint32_t, std::uint32_t> index_of;  // by index of the surface
  std::vector<Extent> extents;
  for (std::size_t i = 0; i < shape.mesh_triangles.size(); ++i) {
    found.of_triangle.push_back(core::kNone);
    const std::uint32_t number = core::surface_of(mesh, shape.mesh_triangles[i]);
    if (number == core::kNone) continue;
    const auto [at, fresh] = index_of.try_emplace(number, std::uint32_t(found.faces.size()));
    if (fresh) {
      found.faces.push_back({placed(surfaces[number], world_from_item, scale), {}, {}});
      extents.emplace_back();
    }
    const core::MeshSurface& surface = found.faces[at->second].surface;
    if (surface.kind == SurfaceKind::kOther) continue;
    found.of_triangle.back() = at->second;
    for (std::size_t k = 0; k < 3; ++k)
      extents[at->second].grow(glm::dot(shape.origin + shape.points[3 * i + k] - surface.origin, surface.axis));
  }
  for (std::size_t i = 0; i < found.faces.size(); ++i) complete(extents[i], found.faces[i]);
  return found;
}

}  // namespace sightline::measure
