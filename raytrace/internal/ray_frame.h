// Moves a ray in double into the neighbourhood of a hierarchy, where its numbers are of the hierarchy's size and float
// begins. Internal to raytrace.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sightline/core/aabb.h"
#include "sightline/core/affine.h"
#include "sightline/gpuprims/internal/local_ray.h"
#include "sightline/raytrace/internal/float4.h"
#include "sightline/raytrace/internal/kernels.h"

namespace sightline::raytrace {

using core::dvec3;
using gpuprims::inverse_power_of_two;
using gpuprims::power_of_two;

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Without the branches of glm::abs().
inline dvec3 magnitude(const dvec3& v) {
  return {std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)};
}

/// The box of everything in a hierarchy, and the sphere about it.
struct TreeSpace {
  dvec3 centre{0.0}, half{0.0};  ///< of the box, half its size
  double radius = -1.0;          ///< below 0: nothing
  double reach = 0.0;            ///< largest coordinate of ray origins near the sphere
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
  /// What float may be wrong by across the ray.
  float across() const { return float(margin * (kBoxError / kMargin)); }
  /// A limit in s for what lies up to `t`.
  float limit(double t) const { return frame_limit(t * per_factor, begin, margin); }
};

inline void set_box_ray(const dvec3& origin, const dvec3& direction, float error, BoxRay& ray) {
  const Float4 o = Float4::of(origin.x, origin.y, origin.z), d = Float4::of(direction.x, direction.y, direction.z);
  const Float4 e = with_signs(Float4::spread(error), d);
  const Float4 inverse = with_signs(Float4::spread(1.0f) / most(magnitude(d), Float4::spread(kLeastDirection)), d);
  (o + e).store(ray.near_origin);
  (o - e).store(ray.far_origin);
  (inverse * Float4::spread(kDown)).store(ray.near_scale);
  (inverse * Float4::spread(kUp)).store(ray.far_scale);
  const unsigned back = signs(d);
  for (int axis = 0; axis < 3; ++axis) {
    const int shift = int(back >> axis & 1u) * 3;
    ray.near_plane[axis] = axis + shift;
    ray.far_plane[axis] = axis + 3 - shift;
  }
}

/// enter() of a ray whose direction is so long or so short that its squares might overflow or vanish.
bool enter_scaled(const TreeSpace& space, const dvec3& origin, const dvec3& direction, double t_min, double t_max,
                  RayFrame& frame);

/// False when the part t_min … t_max of the ray does not come near `space`; it may be true nevertheless. A ray that
/// begins near stays where it begins. Others start within the margin before t_min or before the sphere, whichever comes
/// later.
inline bool enter(const TreeSpace& space, const dvec3& origin, const dvec3& direction, double t_min, double t_max,
                  RayFrame& frame) {
  const double longest = std::max(std::fabs(direction.x), std::max(std::fabs(direction.y), std::fabs(direction.z)));
  if (!(longest > 0x1p-200 && longest < 0x1p200) || space.radius < 0.0)
    return enter_scaled(space, origin, direction, t_min, t_max, frame);
  const double factor = inverse_power_of_two(longest), per_factor = power_of_two(longest);
  const dvec3 to_centre = space.centre - origin, far = magnitude(to_centre);
  double first = t_min * per_factor, last = t_max * per_factor;
  const double near = kNear * space.radius;
  if (!(std::max(std::max(far.x, far.y), std::max(far.z, kNear * std::fabs(first))) <= near)) {
    // Powers of two do not round. So what decides takes the direction as given, and need not wait for its length.
    const dvec3 moment = glm::cross(to_centre, direction);
    const double square = glm::dot(direction, direction);
    const double radius = space.radius + 1e-15 * (far.x + far.y + far.z) + 2.0 * kBoxError * space.reach;
    if (!(glm::dot(moment, moment) <= radius * radius * square)) return false;
    const double closest = per_factor * (glm::dot(to_centre, direction) / square);
    first = std::max(first, closest - radius);
    last = std::min(last, closest + radius);
  }
  if (!(first <= last)) return false;
  frame.factor = factor;
  frame.per_factor = per_factor;
  frame.margin = kMargin * space.reach;
  frame.begin = first - frame.margin;
  const dvec3 d = frame.direction = factor * direction;
  frame.origin = origin + frame.begin * d;
  set_box_ray(frame.origin, d, float(kBoxError * space.reach), frame.boxes);
  frame.boxes.t_max = frame_limit(last, frame.begin, frame.margin);
  return true;
}

/// Whether the line through a ray passes the box by, further away than float may be wrong. May say false where it does.
/// What separates a line from a box is perpendicular to the line and to one of the axes.
inline bool passes_by(const TreeSpace& space, const dvec3& origin, const dvec3& direction) {
  const dvec3 to = space.centre - origin, moment = glm::cross(to, direction), along = magnitude(direction);
  const double lost = 1e-15 * (std::fabs(to.x) + std::fabs(to.y) + std::fabs(to.z)) + 2.0 * kBoxError * space.reach;
  const dvec3 half = space.half + lost;
  return std::fabs(moment.x) > half.y * along.z + half.z * along.y ||
         std::fabs(moment.y) > half.z * along.x + half.x * along.z ||
         std::fabs(moment.z) > half.x * along.y + half.y * along.x;
}

/// The axis of the largest component, and the other two in turn.
struct Axes {
  int x, y, z;
  explicit Axes(const dvec3& direction) {
    const dvec3 size = magnitude(direction);
    z = size.z >= size.x && size.z >= size.y ? 2 : size.y >= size.x ? 1 : 0;
    x = z == 2 ? 0 : z + 1;
    y = x == 2 ? 0 : x + 1;
  }
};

/// The ray of a frame, prepared for triangles.
inline TriangleRay triangle_ray(const RayFrame& frame) {
  const Axes axes(frame.direction);
  const double o[3] = {frame.origin.x, frame.origin.y, frame.origin.z};
  const double d[3] = {frame.direction.x, frame.direction.y, frame.direction.z};
  const double along = 1.0 / d[axes.z];
  return {{axes.x, axes.y, axes.z},
          {float(o[axes.x]), float(o[axes.y]), float(o[axes.z])},
          {float(d[axes.x] * along), float(d[axes.y] * along), float(along)}};
}

/// The ray's crossing with a triangle, in s. Where the ray passes a rounding error outside, or sees the triangle edge
/// on, the nearest point of the outline counts. Corners count where the ray is nearest to them: so whatever the
/// roundings across the ray, s lies between those of the corners.
double crossing(const RayFrame& frame, const dvec3 (&corners)[3]);

}  // namespace sightline::raytrace
