// Internal: sixteen rays side by side, for images. See kernels.h on what the kernels' files may include.
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
/// `inverse`, then by `scale`. `moves_only`: the columns times `inverse` are the identity.
struct LaneMap {
  double shift[2][3], column[3][3], inverse, scale;
  bool moves_only;
};

/// TreeSpace, and what to subtract from origins first.
struct LaneSpace {
  double shift[3], centre[3], half[3], radius, reach;
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
  float t[kPacket], lost[kPacket];
  std::uint32_t triangle[kPacket], place[kPacket];
};

/// The lower face of a box along each axis. The upper one is next.
inline constexpr int kBoxFaces[] = {8, 10, 1};

/// gpuprims::Wedge: the sweep of a torus.
struct Sweep {
  bool whole, convex, flat;
  bool needs_chord;  ///< rounding errors may decide whether a chord lies within, by its middle
  double middle[2], end[2];
};

/// A solid that packets intersect side by side, in its item's coordinates. All numbers are finite.
struct SolidShape {
  enum Kind {
    kBox,               ///< size: half extents, one of which may be 0
    kCylinder,          ///< radius above 0, half height
    kDome,              ///< radius, bulge above 0, height above 0 as gpuprims/internal/dome.h has them; `whole`
    kSnout,             ///< bottom and top radius, one above 0, and height above 0; `offset`; level ends
    kRectangularTorus,  ///< inner and outer radius, half height
    kCircularTorus,     ///< major and tube radius, above 0
  } kind = kBox;
  double size[3] = {}, offset[2] = {};
  bool whole = false;
  Sweep sweep = {};  ///< of tori
};

/// The nearest hits of a packet's rays so far.
struct alignas(64) NearestLanes {
  double t[kPacket];
  double normal[3][kPacket], face[kPacket];     ///< of solids, in the item's coordinates
  std::uint32_t slot[kPacket], place[kPacket];  ///< slot: kNoSlot: none; place: of meshes
};
inline constexpr std::uint32_t kNoSlot = 0xffffffffu;

/// Packets that may walk together.
inline constexpr int kTogether = 4;

/// A packet and those of its rays that are on their way.
struct PacketPart {
  const PacketFrame* frame;
  unsigned rays;
};

/// What happens at a leaf of packets' walk over items: rays[i] of packet i meet its box. It may shrink
/// PacketFrame::limit.
struct PacketVisitor {
  void (*visit)(PacketVisitor& visitor, std::uint32_t leaf, const unsigned* rays);
};

/// As HitFilter.
struct PacketFilter {
  float (*crossed)(const PacketFilter& filter, int ray, std::uint32_t place);
};

struct PacketQuery {
  const WideNode* nodes;
  const TriangleBlock* blocks;
  std::uint32_t root;
  float t_sure, across;
  const PacketFilter* filter;
};

struct PacketKernels {
  /// Takes `count` rays of eight doubles each: origin, direction, ends; the last one fills the lanes that are left.
  /// Returns those that the tracer accepts.
  unsigned (*load)(const double* rays, int count, RayLanes& out);
  void (*to_item)(const RayLanes& rays, const LaneMap& map, RayLanes& out);
  /// Bits of those `rays` that passes_by() does not exclude.
  unsigned (*near)(const RayLanes& lanes, unsigned rays, const LaneSpace& space);
  /// enter() of all rays. Returns those of `rays` that come near.
  unsigned (*enter)(const RayLanes& lanes, unsigned rays, const LaneSpace& space, PacketFrame& frame);
  void (*walk)(const WideNode* nodes, std::uint32_t root, const PacketFrame& frame, unsigned rays,
               PacketVisitor& visitor);
  /// Walks for `count` packets, up to kTogether, as one. False: they are too far apart; some leaves may have been
  /// visited.
  bool (*walk_as_one)(const WideNode* nodes, std::uint32_t root, const PacketPart* packets, int count,
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
  /// Moves those of `rays` into a solid's item and takes their first crossings that are nearer than `best`. Returns the
  /// rays that have a new hit.
  unsigned (*solid)(const SolidShape& shape, const LaneMap& map, const RayLanes& rays, unsigned who, std::uint32_t slot,
                    NearestLanes& best);
  /// Nothing beyond these t is of interest from now on.
  void (*shorten)(const double* t, PacketFrame& frame);
};

const PacketKernels& scalar_packet_kernels();
const PacketKernels& neon_packet_kernels();
const PacketKernels& avx2_packet_kernels();
const PacketKernels& avx512_packet_kernels();
/// The kernels of core::instruction_set().
const PacketKernels& packet_kernels();

}  // namespace sightline::raytrace
