// The lines by which people read the shape of a mesh.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/mesh.h"

namespace sightline::core {

/// Two vertices of a mesh, the one that comes first in it before the other.
using MeshEdge = std::array<std::uint32_t, 2>;

enum class MeshEdges : std::uint8_t {
  /// Borders, and where the surface bends. With surfaces_stored_with() those between two faces, unless their normals
  /// agree there; inside of a face none. In other meshes those where triangles meet at more than kCreaseAngle; normals
  /// that run on smoothly excuse up to kSmoothAngle, as between the facets of a round rod.
  kFeature,
  kAll,  ///< of all triangles
};
inline constexpr double kCreaseAngle = 0.5235987755982988;  ///< radians; 30 degrees
inline constexpr double kSmoothAngle = 1.0471975511965976;  ///< radians; 60 degrees

/// Each edge once, also where vertices are doubled for their normals. Triangles without area count for no bend, and
/// edges of no length and with coordinates that are not finite are left out. `mesh` must pass validate(). Sorts the
/// mesh's edges: about 0.2 us per index.
SIGHTLINE_API std::vector<MeshEdge> edges_of(const Mesh& mesh, MeshEdges which = MeshEdges::kFeature);

}  // namespace sightline::core
