// Internal: the inner loops of the tracer, one form per instruction set, behind plain pointers. The files that define
// them are compiled for their instruction set. So they must not call inline functions of other headers: the linker
// might use their copy in code for every processor.
//
// All forms visit the same children in the same order, and compute with the same roundings.
#pragma once

#include <cstdint>

#include "sightline/raytrace/internal/wide_node.h"

namespace sightline::raytrace {

/// Levels of a hierarchy at most; see kDeepLevel in wide_tree.cpp.
inline constexpr int kMostLevels = 32;

// Errors of rays that float takes. In units of TreeSpace::reach, of which a float resolves 2^-24.
inline constexpr double kBoxError = 0x1p-21;  // of origin, direction and triangle test across the ray
inline constexpr double kMargin = 0x1p-18;    // along it
/// A ray whose origin is so near to the middle of a hierarchy, in each coordinate and in units of TreeSpace::radius, is
/// not moved towards it if it begins within a radius of its origin. Its origin stays within TreeSpace::reach.
inline constexpr double kNear = 2.0;
// Errors of a plane's distance: rounding of difference, direction, reciprocal and product.
inline constexpr float kUp = 1.0f + 0x1p-21f, kDown = 1.0f - 0x1p-21f;
inline constexpr float kLeastDirection = 0x1p-60f;  // crosses kBoxError only after more than the whole reach

/// A ray for boxes, from t = 0 on. It errs towards meeting them: the planes through which it enters a box are as near
/// as its origin and direction may be wrong, those through which it leaves as far.
struct BoxRay {
  float near_origin[4], far_origin[4];  ///< three, and one unused
  float near_scale[4], far_scale[4];    ///< 1 / direction, finite
  int near_plane[3], far_plane[3];      ///< of WideNode::bounds
  float t_max;
};

/// A ray for triangles (S. Woop, C. Benthin, I. Wald, "Watertight ray/triangle intersection", 2013): axes in the order
/// of the projection, the direction's largest component last; shear x / z, y / z and 1 / z.
struct TriangleRay {
  int axes[3];
  float origin[3], shear[3];
};

/// Decides in double what float cannot.
struct HitFilter {
  /// Where the ray crosses a triangle; NaN: beyond its ends, or not to be hit.
  float (*crossed)(HitFilter& filter, std::uint32_t place);
};

/// A ray and the triangles of a mesh. A root with kLeafBit is a block.
struct TriangleQuery {
  const WideNode* nodes;
  const TriangleBlock* blocks;
  std::uint32_t root;
  const BoxRay* boxes;
  TriangleRay ray;
  float t_sure;  ///< hits with a lesser t are asked about
  float across;  ///< what float may be wrong by across the ray
  HitFilter* filter;
};

struct TriangleHit {
  float t;                 ///< infinite: none
  float lost;              ///< t may be wrong by
  std::uint32_t triangle;  ///< kNoTriangle: none
  std::uint32_t place;     ///< of its corners: kLanes * block + lane
};
inline constexpr std::uint32_t kNoTriangle = 0xffffffffu;

/// What happens at a leaf of a walk over items.
struct LeafVisitor {
  /// Returns the t beyond which nothing is of interest from now on; below 0: the walk ends.
  float (*visit)(LeafVisitor& visitor, std::uint32_t leaf, float t_max);
};

struct Kernels {
  /// Visits leaves whose boxes the ray meets up to the limit, boxes of a node in the order in which it enters them.
  /// Returns the last limit.
  float (*walk)(const WideNode* nodes, std::uint32_t root, const BoxRay& ray, LeafVisitor& visitor);
  /// The triangle with the least t; at one t the lowest index.
  TriangleHit (*nearest)(const TriangleQuery& query);
  /// Any triangle that is hit.
  TriangleHit (*any)(const TriangleQuery& query);
};

const Kernels& scalar_kernels();
const Kernels& neon_kernels();
const Kernels& avx2_kernels();
const Kernels& avx512_kernels();
/// The kernels of core::instruction_set().
const Kernels& kernels();

}  // namespace sightline::raytrace
