// Nodes of the hierarchies that rays traverse, over items and over triangles alike, and the triangles of a leaf.
#pragma once

#include <cstdint>

namespace sightline::raytrace {

/// Children of a node, and triangles of a block.
inline constexpr int kLanes = 8;

/// A child is a node or, with this bit, a leaf: a slot, or a block of triangles.
inline constexpr std::uint32_t kLeafBit = 0x80000000u;

/// Boxes of eight children: min x, min y, min z, max x, max y, max z. Unused lanes come last and have the empty box.
/// (I. Wald, C. Benthin, S. Boulos, "Getting rid of packets", 2008.)
struct alignas(64) WideNode {
  float bounds[6][kLanes];
  std::uint32_t children[kLanes];
  std::uint32_t parent;  ///< kLanes * node + lane; core::kNone for a root
};
static_assert(sizeof(WideNode) == 256);

/// Corners of up to eight triangles. Unused lanes are NaN, which nothing hits.
struct alignas(64) TriangleBlock {
  float corners[3][3][kLanes];  ///< corner, axis
  std::uint32_t triangles[kLanes];
};
static_assert(sizeof(TriangleBlock) == 320);

}  // namespace sightline::raytrace
