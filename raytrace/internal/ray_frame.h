// Moves a ray in double into the neighbourhood of a hierarchy, where its numbers are of the hierarchy's size and float
// begins. Internal to raytrace.
#pragma once

#include <cmath>
#include <limits>

#include "sightline/core/aabb.h"
#include "sightline/core/affine.h"
#include "sightline/raytrace/internal/kernels.h"

namespace sightline::raytrace {

using core::dvec3;

/// A sphere about everything in a hierarchy.
struct TreeSpace {
  dvec3 centre{0.0};
  double radius = -1.0;  ///< below 0: nothing
  double reach = 0.0;    ///< largest coordinate of ray origins near the sphere
};
TreeSpace space_around(const core::AabbD& box);

/// A limit for float in a frame that begins there, `margin` wide: of what lies up to `s` from the ray's own origin.
inline float frame_limit(double s, double begin, double margin) {
  const double limit = (s - begin) * (1.0 + 0x1p-20) + margin;
  return limit < 1e38 ? float(limit) : std::numeric_limits<float>::infinity();
}

/// A ray with its origin near a hierarchy. Its parameter s is 0 there; the given ray's t is (begin + s) * factor.
struct RayFrame {
  dvec3 origin, direction;           ///< the largest component of the direction lies in [1, 2)
  double begin, factor, per_factor;  ///< per_factor = 1 / factor, both powers of two
  double margin;                     ///< s that float may be wrong by
  BoxRay boxes;

  double t(double s) const { return (begin + s) * factor; }
  /// A limit in s for what lies up to `t`.
  float limit(double t) const { return frame_limit(t * per_factor, begin, margin); }
};

/// False when the part t_min … t_max of the ray does not come near `space`. The ray starts within the margin before
/// t_min or before the sphere, whichever comes later.
bool enter(const TreeSpace& space, const dvec3& origin, const dvec3& direction, double t_min, double t_max,
           RayFrame& frame);

/// Whether the line through a ray passes by. May say false where it does.
inline bool passes_by(const TreeSpace& space, const dvec3& origin, const dvec3& direction) {
  const dvec3 to = space.centre - origin, moment = glm::cross(to, direction);
  const double radius = space.radius + 1e-15 * (std::fabs(to.x) + std::fabs(to.y) + std::fabs(to.z));
  return glm::dot(moment, moment) > radius * radius * (1.0 + 1e-12) * glm::dot(direction, direction);
}

/// The same ray for triangles.
TriangleRay triangle_ray(const RayFrame& frame);

/// The ray's crossing with a triangle, in s. Where the ray passes a rounding error outside, or sees the triangle edge
/// on, the nearest point of the outline counts.
double crossing(const RayFrame& frame, const dvec3 (&corners)[3]);

}  // namespace sightline::raytrace
