// Internal to the importers: polygons as files hold them, and how they become a mesh of the scene.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/core/mesh.h"

namespace sightline::importers {

/// Faces over shared vertices. Every corner is below positions.size().
struct PolygonMesh {
  std::vector<core::dvec3> positions;     ///< any bits
  std::vector<core::vec3> normals;        ///< one per position, or none
  std::vector<std::uint32_t> corners;     ///< counter-clockwise from outside, faces back to back
  std::vector<std::uint32_t> face_sizes;  ///< empty: all faces are triangles

  std::size_t face_count() const { return face_sizes.empty() ? corners.size() / 3 : face_sizes.size(); }
};

/// Makes the last `size` corners a face, for readers that add faces one by one. `mesh`: a PolygonMesh, or what holds
/// `corners` of another type and `face_sizes` as it does.
template <class Mesh>
void end_face(Mesh& mesh, std::uint32_t size) {
  if (size == 3 && mesh.face_sizes.empty()) return;
  if (mesh.face_sizes.empty()) mesh.face_sizes.assign((mesh.corners.size() - size) / 3, 3);
  mesh.face_sizes.push_back(size);
}

/// Calls visit(first corner, corners) for each face of the same.
template <class Mesh, class Visit>
void for_each_face(const Mesh& mesh, Visit&& visit) {
  std::size_t first = 0;
  if (mesh.face_sizes.empty())
    for (; first + 3 <= mesh.corners.size(); first += 3) visit(first, std::uint32_t{3});
  for (const std::uint32_t size : mesh.face_sizes) {
    visit(first, size);
    first += size;
  }
}

/// A coordinate beyond this counts as damage: items that reach 1e37 m cannot be committed.
inline constexpr double kLargestCoordinate = 1e36;

struct CentredMesh {
  core::Mesh mesh;
  core::dvec3 centre{0.0};  ///< mesh coordinates are relative to it
  std::uint64_t dropped =
      0;                   ///< faces of fewer than three corners, or with a corner that is not finite or too far away
  std::uint64_t flat = 0;  ///< faces of more than three corners without area, left out
  std::uint64_t mended_normals = 0;  ///< those that are not finite, taken from the triangles about their vertices
};

/// Makes positions relative to the centre of their box, in double, before they become float. So precision follows the
/// mesh and not the site. Leaves out vertices that no face uses; the others keep their order. Faces become triangles
/// (triangulate.h).
CentredMesh centred(const PolygonMesh& polygons);

}  // namespace sightline::importers
