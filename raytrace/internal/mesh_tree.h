// The hierarchy over the triangles of one mesh. Internal to raytrace.
#pragma once

#include <stop_token>

#include "sightline/core/large_array.h"
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

  std::uint32_t triangle(std::uint32_t place) const { return blocks[place / kLanes].triangles[place % kLanes]; }
  /// Corners of the triangle at a place, in units.
  void corners(std::uint32_t place, dvec3 (&out)[3]) const {
    const TriangleBlock& block = blocks[place / kLanes];
    const std::uint32_t lane = place % kLanes;
    for (int i = 0; i < 3; ++i)
      out[i] = {block.corners[i][0][lane], block.corners[i][1][lane], block.corners[i][2][lane]};
  }

  std::size_t memory_bytes() const {
    return sizeof(*this) + nodes.capacity() * sizeof(WideNode) + blocks.capacity() * sizeof(TriangleBlock);
  }
};

/// What the triangles enclose: see core::enclosure().
core::Enclosure enclosure_of(const MeshTree& tree);

/// Triangles with a corner that is not finite are left out. `threads`, `stop`: see build_wide_tree(); the result is
/// then empty.
MeshTree build_mesh_tree(const core::Mesh& mesh, int threads, const std::stop_token& stop = {});

}  // namespace sightline::raytrace
