// How far outwards section planes are moved, so that they keep what lies in them up to rounding.
//
// A half-space of a section is closed: it keeps the points of its plane. But the face of an item that is to lie in the
// plane is seldom there exactly. Its place in the chunk, its linear map and its parameters are floats, each off by at
// most 2^-24 of its size, and the world coordinates of chunks and planes are doubles. A section therefore also keeps
// what lies outside its plane by no more than that, and cuts where the plane so moved meets an item. So what touches
// the plane from the kept side is whole, wherever in the world it lies. In double precision nothing else counts, and
// section_margin() bounds it; shaders, which compute in float, have kSectionRounding of sections.glsl.
#pragma once

#include <algorithm>
#include <cmath>

#include "sightline/core/conventions.h"

namespace sightline::core {

/// The rounding of a point, as a share of the sum of an item's coordinates in its chunk and of its points' in the item,
/// all absolute. A point is off by 2^-24 of the first, and by 2 * 2^-24 of the second for the map and the parameters.
/// The coordinates along an axis are sums of up to three terms, whose absolute sum is at most sqrt(3) times as large
/// where the map turns: 3.5 in all.
inline constexpr double kFloatRounding = 4.0 * 0x1p-24;
/// The rounding of world coordinates through a few products and sums in double.
inline constexpr double kWorldRounding = 16.0 * 0x1p-53;

/// By how much the plane's value may be too low at a point of an item. `coordinates`: of the item in its chunk and of
/// its points in the item, absolute and along the world's axes; `world`: those of the chunk.
inline double section_margin(const Plane& plane, const dvec3& coordinates, const dvec3& world) {
  const dvec3 n = glm::abs(plane.normal);
  return kFloatRounding * glm::dot(n, coordinates) + kWorldRounding * (glm::dot(n, world) + std::abs(plane.offset));
}

/// The plane moved outwards for all items within an extent: `origin` and the largest coordinates relative to it. Places
/// in a chunk, and in an item, are differences of two places within the extent.
inline Plane moved_outwards(const Plane& plane, const dvec3& origin, const dvec3& largest) {
  return {plane.normal, plane.offset + section_margin(plane, 4.0 * largest, glm::abs(origin) + largest)};
}

/// The half-space with a normal of unit length. The normal must be finite and not zero.
inline Plane normalised(const Plane& plane) {
  const dvec3 a = glm::abs(plane.normal);
  const double largest = std::max({a.x, a.y, a.z});  // no square over- or underflows
  const dvec3 n = plane.normal / largest;
  const double length = glm::length(n);
  return {n / length, plane.offset / largest / length};
}

}  // namespace sightline::core
