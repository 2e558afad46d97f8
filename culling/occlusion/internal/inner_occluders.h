// Internal: flat polygons within an analytic solid that face the eye, and so hide nearly what the solid hides; and in
// front of it, through which it is seen.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/affine.h"
#include "sightline/core/primitive.h"

namespace sightline::culling {

/// Corners relative to the eye, with the axes of the world: of a convex polygon, seen from both sides, or of a convex
/// solid between two faces of four corners. Of a polygon of four corners, which need not be in one plane, both
/// triangles over one diagonal lie within the solid. Of a hexahedron, corners 0 to 3 turn left as seen from the other
/// face, 4 to 7 lie over these, and all six faces are plane.
struct OccluderPolygon {
  OccluderPolygon() {}  // leaves the corners as they are
  static constexpr int kMostCorners = 8;
  std::span<const core::dvec3> points() const { return {corners.data(), std::size_t(count)}; }

  std::array<core::dvec3, kMostCorners> corners;
  int count;
  bool hexahedron;
  double growth;  // of a hexahedron: made so many times as large about its middle, it contains the solid; 0: unknown
};

/// A solid with a number of occluder polygons in it. The solid and what else must be whole, so that nothing is seen
/// behind the occluder polygons, lie in the box: relative to the eye, with the axes of the world.
struct WholeSolid {
  core::AabbD box;
  std::uint32_t polygons;
};

/// How the eye sees: from a point, or along a direction.
struct EyeProjection {
  bool perspective;
  core::dvec3 forward;  // the direction, or any where the view is perspective
};

/// Appends occluder polygons within a primitive, in no order; none for lines, meshes, singular placements, and what has
/// no volume or parameters that are not finite. They are smaller than the solid: by `of_radius` of its radius (tori by
/// four times that of the tube's, and a fortieth of the other), and by `metres`.
void add_inner_occluders(core::Kind kind, const float* parameters, const core::Affine& eye_from_item,
                         const EyeProjection& projection, double of_radius, double metres,
                         std::vector<OccluderPolygon>& polygons);

/// Appends quads in front of a cylinder, a snout or a circular torus, and so near to it that they are seen where the
/// solid is, or little more. Each line of sight to the solid crosses one of them first. They count for the solid made
/// larger by `of_radius` of its radius and by `metres`. False, with anything appended, where there are none.
bool add_fronts(core::Kind kind, const float* parameters, const core::Affine& eye_from_item,
                const EyeProjection& projection, double of_radius, double metres, std::vector<OccluderPolygon>& fronts);

}  // namespace sightline::culling
