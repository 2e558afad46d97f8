// The sides of a mesh's triangles, those of one edge together.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/affine.h"
#include "sightline/core/mesh.h"
#include "sightline/core/mesh_extras.h"

namespace sightline::core {

/// A side of a triangle.
struct MeshSide {
  std::uint64_t ends;    // welded vertices, the lower one first
  std::uint32_t corner;  // index in Mesh::indices at which it begins
  std::uint32_t face;    // of the surfaces that came with the mesh
  bool forward;          // from the lower to the higher welded vertex
};

/// The corner at which the side ends that begins at this one.
inline std::uint32_t end_of(std::uint32_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}

/// All that have a length and finite ends, sorted by these, then by corner.
inline std::vector<MeshSide> sides_of(const Mesh& mesh) {
  const std::vector<std::uint32_t> welded = weld(mesh.positions);
  const std::span<const MeshSurface> surfaces = surfaces_stored_with(mesh);
  std::vector<MeshSide> sides;
  sides.reserve(mesh.indices.size());
  std::uint32_t face = 0;
  for (std::uint32_t corner = 0; corner < mesh.indices.size(); ++corner) {
    while (face < surfaces.size() && corner / 3 >= surfaces[face].end_triangle) ++face;
    const std::uint32_t a = welded[mesh.indices[corner]], b = welded[mesh.indices[end_of(corner)]];
    if (a == b || !is_finite(dvec3(mesh.positions[a])) || !is_finite(dvec3(mesh.positions[b]))) continue;
    sides.push_back({std::uint64_t(std::min(a, b)) << 32 | std::max(a, b), corner, face, a < b});
  }
  std::sort(sides.begin(), sides.end(), [](const MeshSide& a, const MeshSide& b) {
    return a.ends != b.ends ? a.ends < b.ends : a.corner < b.corner;
  });
  return sides;
}

/// Calls visit(std::span<const MeshSide>) for the sides of each edge.
template <class Visit>
void for_each_edge(std::span<const MeshSide> sides, Visit&& visit) {
  for (std::size_t first = 0, end = 0; first < sides.size(); first = end) {
    while (end < sides.size() && sides[end].ends == sides[first].ends) ++end;
    visit(sides.subspan(first, end - first));
  }
}

}  // namespace sightline::core
