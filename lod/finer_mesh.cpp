#include "sightline/lod/finer_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "sightline/core/internal/mesh_sides.h"

namespace sightline::lod {
namespace {

using core::dvec3, core::kNone, core::MeshSide, core::MeshSurface, core::vec3;

constexpr int kMostPasses = 10;       // each takes three quarters of the gap away
constexpr int kProjections = 12;      // in turn onto two surfaces
constexpr double kLeastCosine = 0.7;  // of normals at both ends, 45 degrees: coarser facets tell too little of a shape
constexpr double kAgreement = 0.25;   // of the tolerance: how far a point of two surfaces may lie off either

bool is_curved(const MeshSurface& surface) {
  return surface.kind != MeshSurface::Kind::kOther && surface.kind != MeshSurface::Kind::kPlane;
}

/// A direction across a surface at a point of it.
dvec3 normal_at(const MeshSurface& surface, const dvec3& p) {
  const dvec3 away = p - surface.origin;
  const dvec3 aside = away - glm::dot(away, surface.axis) * surface.axis;
  switch (surface.kind) {
    case MeshSurface::Kind::kPlane:
      return surface.axis;
    case MeshSurface::Kind::kSphere:
      return away;
    case MeshSurface::Kind::kCylinder:
      return aside;
    case MeshSurface::Kind::kCone:
      return glm::normalize(aside) - surface.slope * surface.axis;
    case MeshSurface::Kind::kTorus:
      return away - surface.radius * glm::normalize(aside);
    default:
      return dvec3(0.0);
  }
}

/// Whether a surface turns so little between two points of it that a side between them follows it.
bool follows(const MeshSurface& surface, const dvec3& a, const dvec3& b) {
  const dvec3 n = normal_at(surface, a), m = normal_at(surface, b);
  return glm::dot(n, m) >= kLeastCosine * glm::length(n) * glm::length(m);
}

/// The place where an edge should be halved.
struct Middle {
  dvec3 chord, point;
  bool follows = true;  // the edge, its surfaces
  double gap() const { return glm::length(point - chord); }
};

/// The triangles of a mesh, or of a finer one, as parts of its faces.
class Facets {
 public:
  explicit Facets(const core::Mesh& mesh) : surfaces_(core::surfaces_stored_with(mesh)) {
    face_of_.resize(mesh.indices.size() / 3);
    for (std::uint32_t t = 0; t < face_of_.size(); ++t) face_of_[t] = core::surface_of(mesh, t);
  }
  std::span<const MeshSurface> surfaces() const { return surfaces_; }
  /// Null where none is known on which the triangle's corners lie.
  const MeshSurface* surface(std::uint32_t triangle) const {
    return face_of_[triangle] == kNone ? nullptr : &surfaces_[face_of_[triangle]];
  }

  /// The point of the surfaces on which the triangles with these sides lie, at their middle; none where no curved one
  /// is known, and where they have no common point near it.
  std::optional<Middle> middle(const core::Mesh& mesh, std::span<const MeshSide> sides, double agreement) const {
    const MeshSurface* on[2] = {};
    for (const MeshSide& side : sides) {
      const MeshSurface* surface = this->surface(side.corner / 3);
      if (!surface || surface == on[0] || surface == on[1]) continue;
      if (on[1]) return std::nullopt;  // more than two
      on[on[0] ? 1 : 0] = surface;
    }
    if (!on[0] || !(is_curved(*on[0]) || (on[1] && is_curved(*on[1])))) return std::nullopt;
    const auto end = [&](std::uint64_t vertex) { return dvec3(mesh.positions[std::uint32_t(vertex)]); };
    const dvec3 a = end(sides[0].ends >> 32), b = end(sides[0].ends);
    Middle middle{0.5 * (a + b), 0.5 * (a + b)};
    for (const MeshSurface* surface : on) middle.follows &= !surface || follows(*surface, a, b);
    for (int i = 0; i < (on[1] ? kProjections : 1); ++i)
      for (const MeshSurface* surface : on)
        if (surface) middle.point = core::nearest_point(*surface, middle.point);
    const bool agrees =
        !on[1] || glm::length(core::nearest_point(*on[0], middle.point) - middle.point) <= on[0]->gap + agreement;
    if (!agrees || !(middle.gap() <= glm::length(b - a))) return std::nullopt;
    return middle;
  }

  /// The facets of a mesh of which each triangle is a part of one of these.
  void replace(std::span<const std::uint32_t> part_of) {
    std::vector<std::uint32_t> face_of;
    face_of.reserve(part_of.size());
    for (const std::uint32_t t : part_of) face_of.push_back(face_of_[t]);
    face_of_ = std::move(face_of);
  }

 private:
  std::span<const MeshSurface> surfaces_;
  std::vector<std::uint32_t> face_of_;  // by triangle, or kNone
};

/// One pass over a mesh: which sides are halved, and the mesh of that.
class Halving {
 public:
  Halving(const core::Mesh& mesh, const Facets& facets)
      : mesh_(mesh), facets_(facets), middle_of_(mesh.indices.size(), kNone) {}

  /// Returns whether any side is halved.
  bool choose(double tolerance) {
    for_each_edge(core::sides_of(mesh_), [&](std::span<const MeshSide> sides) {
      const auto middle = facets_.middle(mesh_, sides, kAgreement * tolerance);
      if (!middle || !middle->follows || !(middle->gap() > tolerance)) return;
      for (const MeshSide& side : sides) middle_of_[side.corner] = std::uint32_t(points_.size());
      points_.push_back(vec3(middle->point));
    });
    halved_.assign(points_.size(), 1);
    keep_what_would_turn();
    return std::find(halved_.begin(), halved_.end(), 1) != halved_.end();
  }

  /// Triangles of the next mesh.
  std::size_t count() const {
    std::size_t count = 0;
    for (std::uint32_t t = 0; t < triangles(); ++t) count += 1 + halves(t);
    return count;
  }

  /// Makes the next mesh; `part_of`: by its triangles, of which triangle each is a part, in their order.
  core::Mesh halve(std::vector<std::uint32_t>& part_of) {
    core::Mesh next{mesh_.name, mesh_.positions, mesh_.normals, {}, {}, {}};
    next.indices.reserve(3 * count());
    for (std::uint32_t t = 0; t < triangles(); ++t) {
      for_each_part(t, [&](const std::array<Corner, 3>& part) {
        for (const Corner& corner : part) next.indices.push_back(vertex(corner, t, next));
        part_of.push_back(t);
      });
    }
    return next;
  }

 private:
  /// A vertex of the mesh, or the middle of the side that begins at that corner of the mesh.
  struct Corner {
    std::uint32_t at;
    bool middle;
  };

  std::uint32_t triangles() const { return std::uint32_t(mesh_.indices.size() / 3); }
  bool is_halved(std::uint32_t corner) const { return middle_of_[corner] != kNone && halved_[middle_of_[corner]] != 0; }
  std::size_t halves(std::uint32_t t) const {
    return std::size_t(is_halved(3 * t)) + is_halved(3 * t + 1) + is_halved(3 * t + 2);
  }

  /// Calls visit() for the one to four triangles that a triangle becomes, which turn as it does.
  template <class Visit>
  void for_each_part(std::uint32_t t, Visit&& visit) const {
    const std::size_t count = halves(t);
    // From the corner on where the pattern begins: one halved side comes first, one that is not comes last.
    std::uint32_t first = 0;
    if (count == 1)
      while (!is_halved(3 * t + first)) ++first;
    if (count == 2)
      while (is_halved(3 * t + (first + 2) % 3)) ++first;
    const std::uint32_t i = 3 * t + first, j = core::end_of(i), k = core::end_of(j);
    const Corner a{i, false}, b{j, false}, c{k, false}, ab{i, true}, bc{j, true}, ca{k, true};
    using Part = std::array<Corner, 3>;
    if (count == 0) return visit(Part{a, b, c});
    if (count == 1) return visit(Part{a, ab, c}), visit(Part{ab, b, c});
    visit(Part{ab, b, bc});
    if (count == 3) return visit(Part{a, ab, ca}), visit(Part{ca, bc, c}), visit(Part{ab, bc, ca});
    // The shorter diagonal of what is left.
    const dvec3 across = position(ab) - position(c), other = position(bc) - position(a);
    if (glm::dot(across, across) < glm::dot(other, other)) return visit(Part{a, ab, c}), visit(Part{ab, bc, c});
    visit(Part{a, ab, bc}), visit(Part{a, bc, c});
  }

  dvec3 position(const Corner& corner) const {
    return dvec3(corner.middle ? points_[middle_of_[corner.at]] : mesh_.positions[mesh_.indices[corner.at]]);
  }

  /// A part of a triangle that would look the other way keeps all sides of the triangle, for which others must be
  /// looked at again.
  void keep_what_would_turn() {
    for (bool kept = true; kept;) {
      kept = false;
      for (std::uint32_t t = 0; t < triangles(); ++t) {
        if (halves(t) == 0 || !turns(t)) continue;
        for (std::uint32_t corner = 3 * t; corner < 3 * t + 3; ++corner)
          if (middle_of_[corner] != kNone) halved_[middle_of_[corner]] = 0;
        kept = true;
      }
    }
  }
  bool turns(std::uint32_t t) const {
    const auto across = [&](const std::array<Corner, 3>& part) {
      return glm::cross(position(part[1]) - position(part[0]), position(part[2]) - position(part[0]));
    };
    const std::array<Corner, 3> itself{Corner{3 * t, false}, Corner{3 * t + 1, false}, Corner{3 * t + 2, false}};
    for (int i = 0; i < 3; ++i)
      if (position(itself[i]) == position(itself[(i + 1) % 3])) return false;  // it stays a line
    const dvec3 whole = across(itself);
    bool any = false;
    for_each_part(t, [&](const std::array<Corner, 3>& part) { any = any || !(glm::dot(whole, across(part)) > 0.0); });
    return any;
  }

  /// Index in the next mesh. A middle becomes one vertex of all triangles that share both ends.
  std::uint32_t vertex(const Corner& corner, std::uint32_t triangle, core::Mesh& next) {
    const std::uint32_t a = mesh_.indices[corner.at];
    if (!corner.middle) return a;
    const std::uint32_t b = mesh_.indices[core::end_of(corner.at)];
    const auto [known, fresh] =
        made_.try_emplace(std::uint64_t(std::min(a, b)) << 32 | std::max(a, b), std::uint32_t(next.positions.size()));
    if (!fresh) return known->second;
    const vec3 point = points_[middle_of_[corner.at]];
    next.positions.push_back(point);
    if (!mesh_.normals.empty()) next.normals.push_back(normal(a, b, triangle, point));
    return known->second;
  }
  /// A normal of the surface, on the side of the normals at both ends.
  vec3 normal(std::uint32_t a, std::uint32_t b, std::uint32_t triangle, const vec3& point) const {
    const dvec3 mean = dvec3(mesh_.normals[a]) + dvec3(mesh_.normals[b]);
    const MeshSurface* surface = facets_.surface(triangle);
    dvec3 normal = surface ? normal_at(*surface, dvec3(point)) : mean;
    if (glm::dot(normal, mean) < 0.0) normal = -normal;
    const double size = glm::length(normal);
    return size > 0.0 ? vec3(normal / size) : mesh_.normals[a];
  }

  const core::Mesh& mesh_;
  const Facets& facets_;
  std::vector<std::uint32_t> middle_of_;  // by corner, of the side that begins there: index of `points_`, or kNone
  std::vector<vec3> points_;
  std::vector<std::uint8_t> halved_;                       // by point
  std::unordered_map<std::uint64_t, std::uint32_t> made_;  // by both ends: the vertex of the next mesh
};

/// The surfaces that came with a mesh, for a finer one; `part_of`: by its triangles, a triangle of the mesh.
core::MeshExtrasSlot extras_of(const Facets& facets, const core::Mesh& finer, std::span<const std::uint32_t> part_of) {
  std::vector<MeshSurface> surfaces(facets.surfaces().begin(), facets.surfaces().end());
  std::uint32_t t = 0;
  for (MeshSurface& surface : surfaces) {
    for (; t < part_of.size() && part_of[t] < surface.end_triangle; ++t) {
      if (!facets.surface(t)) continue;
      for (std::uint32_t corner = 3 * t; corner < 3 * t + 3; ++corner) {
        const dvec3 p(finer.positions[finer.indices[corner]]);
        surface.gap = std::max(surface.gap, glm::length(core::nearest_point(surface, p) - p));
      }
    }
    surface.end_triangle = t;
  }
  core::MeshExtras extras;
  extras.surfaces = std::make_shared<const std::vector<MeshSurface>>(std::move(surfaces));
  return core::MeshExtrasSlot(std::move(extras));
}

}  // namespace

bool has_curved_faces(const core::Mesh& mesh) {
  return std::ranges::any_of(core::surfaces_stored_with(mesh), is_curved);
}

double facet_gap(const core::Mesh& mesh) {
  if (!has_curved_faces(mesh) || mesh.is_facet_group()) return 0.0;
  const Facets facets(mesh);
  double gap = 0.0;
  for_each_edge(core::sides_of(mesh), [&](std::span<const MeshSide> sides) {
    if (const auto middle = facets.middle(mesh, sides, std::numeric_limits<double>::infinity()))
      gap = std::max(gap, middle->gap());
  });
  return gap;
}

std::optional<core::Mesh> finer_mesh(const core::Mesh& mesh, double tolerance, std::size_t most) {
  if (!has_curved_faces(mesh) || mesh.is_facet_group()) return std::nullopt;
  Facets facets(mesh);
  std::optional<core::Mesh> finer;
  std::vector<std::uint32_t> part_of;  // by triangle of `finer`: one of `mesh`
  for (int pass = 0; pass < kMostPasses; ++pass) {
    Halving halving(finer ? *finer : mesh, facets);
    if (!halving.choose(tolerance) || halving.count() > most) break;
    std::vector<std::uint32_t> parts;
    core::Mesh next = halving.halve(parts);
    facets.replace(parts);
    if (finer)
      for (std::uint32_t& part : parts) part = part_of[part];
    part_of = std::move(parts);
    finer = std::move(next);
  }
  if (finer) finer->extras = extras_of(facets, *finer, part_of);
  return finer;
}

}  // namespace sightline::lod
