#include "sightline/core/mesh_edges.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "sightline/core/internal/mesh_sides.h"
#include "sightline/core/mesh_extras.h"

namespace sightline::core {
namespace {

constexpr double kSameNormals = 0.087;  // radians, 5 degrees: how far the normals of a smooth seam may differ

/// Angle between two directions, radians; 0 where one has no length.
double angle_between(const dvec3& a, const dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

class Bends {
 public:
  explicit Bends(const Mesh& mesh) : mesh_(mesh), has_faces_(!surfaces_stored_with(mesh).empty()) {}

  /// Whether the triangles with these sides, all of one edge, make it one to be seen.
  bool shows(std::span<const MeshSide> sides) const {
    if (sides.size() == 1) return true;
    if (sides.size() > 2) return splits(sides);
    const MeshSide &a = sides[0], &b = sides[1];
    if (has_faces_) return a.face != b.face && !(has_normals() && smooth(a, b));
    const double bend = angle_between(normal(a), (a.forward != b.forward ? 1.0 : -1.0) * normal(b));
    return bend > kCreaseAngle && !(bend <= kSmoothAngle + kRounding && has_normals() && smooth(a, b));
  }

 private:
  static constexpr double kRounding = 1e-3;  // radians: of prisms with six sides

  bool has_normals() const { return !mesh_.normals.empty(); }
  dvec3 normal(const MeshSide& side) const {
    const std::uint32_t first = side.corner / 3 * 3;
    const auto at = [&](std::uint32_t i) { return dvec3(mesh_.positions[mesh_.indices[first + i]]); };
    return glm::cross(at(1) - at(0), at(2) - at(0));
  }
  /// Whether the normals of both sides agree at both ends.
  bool smooth(const MeshSide& a, const MeshSide& b) const {
    const auto at = [&](const MeshSide& side, bool lower) {
      return dvec3(mesh_.normals[mesh_.indices[side.forward == lower ? side.corner : end_of(side.corner)]]);
    };
    return angle_between(at(a, true), at(b, true)) <= kSameNormals &&
           angle_between(at(a, false), at(b, false)) <= kSameNormals;
  }
  /// Where more than two triangles meet: unless all lie in one plane, as those of sheets with two faces do.
  bool splits(std::span<const MeshSide> sides) const {
    const dvec3 first = normal(sides[0]);
    return sides.size() % 2 == 1 || std::any_of(sides.begin() + 1, sides.end(), [&](const MeshSide& side) {
             const double angle = angle_between(first, normal(side));
             return std::min(angle, 3.14159265358979 - angle) > kCreaseAngle;
           });
  }

  const Mesh& mesh_;
  bool has_faces_;
};

}  // namespace

std::vector<MeshEdge> edges_of(const Mesh& mesh, MeshEdges which) {
  const std::vector<MeshSide> sides = sides_of(mesh);
  const Bends bends(mesh);
  std::vector<MeshEdge> edges;
  for_each_edge(sides, [&](std::span<const MeshSide> same) {
    if (which == MeshEdges::kAll || bends.shows(same))
      edges.push_back({std::uint32_t(same[0].ends >> 32), std::uint32_t(same[0].ends)});
  });
  return edges;
}

}  // namespace sightline::core
