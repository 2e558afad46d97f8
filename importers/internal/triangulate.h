// Triangles over planar polygons with holes, as facet groups and OBJ faces hold them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/conventions.h"

namespace sightline::importers {

/// Twice the area vector of a closed polygon (Newell): its direction is the normal about which the vertices run
/// counter-clockwise, its length twice the area. Zero for fewer than three vertices.
core::dvec3 newell_normal(std::span<const core::vec3> polygon);

/// Appends triangles that cover one polygon, as three indices each: `base` + index into `vertices`. `vertices` holds
/// the contours back to back. The first contour is the outline. A later one that starts inside it is a hole, any other
/// a further outline. Triangles are counter-clockwise about their outline's Newell normal, whichever way holes run. No
/// vertex is added.
///
/// Ear clipping over the projection along the normal's largest axis, with holes joined by bridges (D. Eberly,
/// "Triangulation by ear clipping", 2002). The cover is exact up to rounding for simple polygons. Crossing, repeated or
/// collinear vertices give some cover with valid indices, and a fan where they make an outline's halves cancel each
/// other out, as in a quad whose sides cross. Zero area gives none. Vertices must be finite. Work is O(n^2) and capped
/// at some thousand steps per vertex: a polygon that needs more (tens of thousands of vertices, mostly reflex) ends in
/// a fan.
void triangulate_polygon(std::span<const core::vec3> vertices, std::span<const std::uint32_t> contour_sizes,
                         std::uint32_t base, std::vector<std::uint32_t>& indices);

}  // namespace sightline::importers
