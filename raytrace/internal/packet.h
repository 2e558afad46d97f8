// Internal: sixteen rays side by side, for pictures. See kernels.h on what the kernels' files may include.
#pragma once

#include <cstdint>

#include "sightline/raytrace/internal/kernels.h"

namespace sightline::raytrace {

inline constexpr int kPacket = 16;

/// Rays, their parts from … to included.
struct alignas(64) RayLanes {
  double origin[3][kPacket], direction[3][kPacket], from[kPacket], to[kPacket];
};

/// Into an item's coordinates: subtracts both shifts from origins, then multiplies by the transposed columns times
/// `inverse`, then by `scale`.
struct LaneMap {
  double shift[2][3], column[3][3], inverse, scale;
};

/// TreeSpace, and what to subtract from origins first.
struct LaneSpace {
  double shift[3], centre[3], radius, reach;
};

/// RayFrame and BoxRay of each ray. Rays that do not come near have any numbers.
struct alignas(64) PacketFrame {
  double origin[3][kPacket], direction[3][kPacket], begin[kPacket], factor[kPacket], per_factor[kPacket];
  double margin;
  alignas(64) float near_origin[3][kPacket];
  float far_origin[3][kPacket], near_scale[3][kPacket], far_scale[3][kPacket];
  float limit[kPacket];     ///< t_max of boxes; shrinks as hits are found
  float start[3][kPacket];  ///< the origin for triangles
  unsigned back[3];         ///< rays whose direction is negative along an axis
  unsigned largest[3];      ///< rays whose direction is largest along an axis
};

/// The nearest triangles of a packet, as TriangleHit.
struct alignas(64) PacketHits {
  float t[kPacket];
  std::uint32_t triangle[kPacket], place[kPacket];
};

/// The lower face of a box along each axis. The upper one is next.
inline constexpr int kBoxFaces[] = {8, 10, 1};

/// The first crossings of rays with a solid at or after RayLanes::from.
struct alignas(64) SolidLanes {
  double t[kPacket];  ///< infinite: none
  double normal[3][kPacket], face[kPacket];
};

/// What happens at a leaf of a packet's walk over items: `rays` meet its box. It may shrink PacketFrame::limit.
struct PacketVisitor {
  void (*visit)(PacketVisitor& visitor, std::uint32_t leaf, unsigned rays);
};

/// Decides what is too close to the start of a ray for float.
struct PacketFilter {
  bool (*accept)(const PacketFilter& filter, int ray, std::uint32_t place);
};

struct PacketQuery {
  const WideNode* nodes;
  const TriangleBlock* blocks;
  std::uint32_t root;
  float t_sure;
  const PacketFilter* filter;
};

struct PacketKernels {
  /// Takes `count` rays of eight doubles each: origin, direction, ends; the last one fills the lanes that are left.
  /// Returns those that the tracer accepts.
  unsigned (*load)(const double* rays, int count, RayLanes& out);
  void (*to_item)(const RayLanes& rays, const LaneMap& map, RayLanes& out);
  /// enter() of all rays. Returns those of `rays` that come near.
  unsigned (*enter)(const RayLanes& lanes, unsigned rays, const LaneSpace& space, PacketFrame& frame);
  void (*walk)(const WideNode* nodes, std::uint32_t root, const PacketFrame& frame, unsigned rays,
               PacketVisitor& visitor);
  /// Hits of `rays` are replaced where there are nearer ones, as by Kernels::nearest().
  void (*nearest)(const PacketQuery& query, unsigned rays, PacketFrame& frame, PacketHits& hits);
  /// crossing() and RayFrame::t() of `rays` with their triangles. Returns those that pass outside, which have no
  /// answer.
  unsigned (*crossings)(const PacketFrame& frame, const TriangleBlock* blocks, const PacketHits& hits, unsigned rays,
                        double* t);
  /// Normals of triangles.
  void (*normals)(const TriangleBlock* blocks, const std::uint32_t* places, unsigned rays, double (*normals)[kPacket]);
  /// Turns normals into the world, with unit length; `columns` are the cofactors of the item's linear part.
  void (*turn)(const double (*columns)[3], bool mirrored, double (*normals)[kPacket]);
  /// A cylinder of a radius above 0 that ends at -half and half, and a box of which one half may be 0. All finite.
  void (*cylinder)(const RayLanes& rays, double radius, double half, SolidLanes& out);
  void (*box)(const RayLanes& rays, const double* half, SolidLanes& out);
};

const PacketKernels& scalar_packet_kernels();
const PacketKernels& avx2_packet_kernels();
const PacketKernels& avx512_packet_kernels();
/// The kernels of core::instruction_set().
const PacketKernels& packet_kernels();

}  // namespace sightline::raytrace
