// The hierarchy over the triangles of one mesh. Internal to raytrace.
#pragma once

#include "sightline/core/internal/large_array.h"
#include "sightline/core/mesh.h"
#include "sightline/raytrace/internal/ray_frame.h"
#include "sightline/raytrace/internal/wide_node.h"

namespace sightline::raytrace {

/// In units of the mesh: a power of two near its size, by which coordinates are scaled without rounding. So products of
/// them neither overflow nor vanish.
struct MeshTree {
  double per_unit = 1.0;  ///< 1 / unit
  TreeSpace space;
  std::uint32_t root = 0;
  bool empty = true;
  core::LargeArray<WideNode> nodes;
  core::LargeArray<TriangleBlock> blocks;

  std::size_t memory_bytes() const {
    return sizeof(*this) + nodes.capacity() * sizeof(WideNode) + blocks.capacity() * sizeof(TriangleBlock);
  }
};

/// Triangles with a corner that is not finite are left out. `threads`: see build_wide_tree().
MeshTree build_mesh_tree(const core::Mesh& mesh, int threads);

/// Corners of a triangle, scaled.
void scaled_corners(const core::Mesh& mesh, double per_unit, std::uint32_t triangle, dvec3 (&corners)[3]);

}  // namespace sightline::raytrace
