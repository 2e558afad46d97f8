// Shared by all reference intersections: moves a ray into the primitive's neighbourhood, clips intervals of the ray
// there, and turns them into hits. Internal to gpuprims.
//
// The ray is moved to a point close to the primitive. From then on all numbers are of the primitive's size, however far
// the eye is and however long the direction. Haines et al., "Precision Improvements for Ray/Sphere Intersection", Ray
// Tracing Gems (2019), chapter 7, show why. Each axis has its own measure of closeness (`weights`): the middle of a
// pipe a million radii long may be as far from the crossing as the eye.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sightline/gpuprims/internal/ray.h"

namespace sightline::gpuprims {

using core::dvec2;

/// One bit per face that is not drawn.
inline unsigned internal_faces(Caps caps) {
  return (caps.bottom ? 0u : 1u << kBottom) | (caps.top ? 0u : 1u << kTop);
}

/// The power of two in (x/2, x] and its inverse, for 0 < x < 2^1023. Scaling by them does not round.
inline double power_of_two(double x) {
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) & 0x7ff0000000000000u);
}
inline double inverse_power_of_two(double x) {
  return std::bit_cast<double>(0x7fe0000000000000u - (std::bit_cast<std::uint64_t>(x) & 0x7ff0000000000000u));
}

/// The ray origin + s * direction, in units of the primitive. The parameter of the original ray is start + s * scale.
/// The largest component of the direction lies in [1, 2).
struct LocalRay {
  dvec3 origin, direction;
  double start, scale;
  bool valid;  ///< false for rays that are not finite or have no direction: they hit nothing

  double t(double s) const { return start + s * scale; }
  dvec3 at(double s) const { return origin + s * direction; }
};

/// A ray with a direction of ordinary length. Directions shorter than 2^1023 are scaled without rounding.
struct ScaledRay {
  dvec3 origin, direction;
  double factor;  ///< original t = factor * t of this ray
};
inline ScaledRay scale_direction(const Ray& ray) {
  const dvec3& d = ray.direction;
  const double factor = inverse_power_of_two(std::max(std::fabs(d.x), std::max(std::fabs(d.y), std::fabs(d.z))));
  return {ray.origin, factor * d, factor};
}

/// Moves the ray's origin to its point at `start`, in units of power_of_two(size). The new origin lies exactly on the
/// given ray, up to one rounding of the remainder (fused multiply-add), so a far eye costs no precision.
inline LocalRay move_to(const ScaledRay& ray, double start, double size) {
  const dvec3 &o = ray.origin, &d = ray.direction;
  const double x = std::fma(start, d.x, o.x), y = std::fma(start, d.y, o.y), z = std::fma(start, d.z, o.z);
  const bool valid = x * x + y * y + z * z + std::fabs(start) < std::numeric_limits<double>::infinity();
  const double per_unit = inverse_power_of_two(size);
  return {{x * per_unit, y * per_unit, z * per_unit},
          {d.x, d.y, d.z},
          start * ray.factor,
          power_of_two(size) * ray.factor,
          valid};
}

/// Weight (a / b)^2 for closest_approach: of an axis along which the primitive reaches b, relative to an axis along
/// which it reaches a. A reach below 1e-12 a counts as 1e-12 a.
inline double weight(double a, double b) {
  const double ratio = a / std::max(b, 1e-12 * a);
  return ratio * ratio;
}

/// The weights of a box with these half extents, at least one of them positive.
inline dvec3 weights(const dvec3& half) {
  const double most = std::max(half.x, std::max(half.y, half.z));
  return {weight(most, half.x), weight(most, half.y), weight(most, half.z)};
}

/// Parameter where the weighted distance to the local origin is least. With weights 1 / extent^2, up to a common
/// factor, the point lies within sqrt(3) extents along each axis if the ray meets the box -extent … extent. Origins may
/// be up to 1e150.
inline double closest_approach(const dvec3& o, const dvec3& d, const dvec3& weights) {
  const dvec3 wd = weights * d;
  return -glm::dot(wd, o) / glm::dot(wd, d);
}
inline LocalRay closest_approach(const Ray& ray, const dvec3& weights, double size) {
  const ScaledRay scaled = scale_direction(ray);
  return move_to(scaled, closest_approach(scaled.origin, scaled.direction, weights), size);
}

/// Moves the origin to the ray's point closest to the local origin, and gives the direction unit length. With a far eye
/// the first move is off by a rounding of the distance.
inline void recentre(LocalRay& ray) {
  const double square = glm::dot(ray.direction, ray.direction), length = std::sqrt(square);
  const double shift = -glm::dot(ray.origin, ray.direction) / square;
  ray.origin += shift * ray.direction;
  ray.start += shift * ray.scale;
  ray.direction /= length;
  ray.scale /= length;
}

/// a.x b.y - a.y b.x.
inline double cross(const dvec2& a, const dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

/// condition ? a : b without a branch, for unpredictable conditions: a mispredicted branch costs more than all the code
/// around it.
inline int choose(bool condition, int a, int b) {
  return b ^ ((a ^ b) & -int(condition));
}

/// A closed interval of s and the faces that bound it. Default: the whole line.
struct Span {
  static constexpr int kNoFace = -1;
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double from = -kInfinity, to = kInfinity;
  int from_face = kNoFace, to_face = kNoFace;

  static Span nothing() { return {1.0, 0.0}; }
  bool empty() const { return !(from <= to); }
  bool bounded() const { return from <= to && from > -kInfinity && to < kInfinity; }

  void enter(double s, int face) {
    from_face = choose(s > from, face, from_face);
    from = std::max(from, s);
  }
  void leave(double s, int face) {
    to_face = choose(s < to, face, to_face);
    to = std::min(to, s);
  }
  /// Keeps the part that both have in common.
  void clip(const Span& other) {
    enter(other.from, other.from_face);
    leave(other.to, other.to_face);
  }
  /// Keeps the part with value + s * slope >= 0.
  void clip(double value, double slope, int face) {
    if (slope > 0) {
      enter(-value / slope, face);
    } else if (slope < 0) {
      leave(-value / slope, face);
    } else if (!(value >= 0)) {
      *this = nothing();
    }
  }
  /// Keeps the part with -half <= value + s * slope <= half. For a slab without thickness that is one point, with both
  /// faces in the order in which the ray meets them, and nothing if the ray lies within the slab.
  void clip_slab(double value, double slope, double half, int low_face, int high_face) {
    if (slope == 0) {
      if (half == 0 || !(std::fabs(value) <= half)) *this = nothing();
      return;
    }
    const double inverse = 1 / slope, middle = -value * inverse, extent = half * std::fabs(inverse);
    enter(middle - extent, choose(slope > 0, low_face, high_face));
    leave(middle + extent, choose(slope > 0, high_face, low_face));
  }
};

/// The parts of `span` outside the open `gap`, in rising order; returns their number, 0 to 2. A gap with equal ends is
/// empty.
inline int subtract(const Span& span, const Span& gap, Span pieces[2]) {
  Span before = span, after = span;
  if (!(gap.from < gap.to))
    after = Span::nothing();
  else
    before.leave(gap.from, gap.from_face), after.enter(gap.to, gap.to_face);
  int count = 0;
  if (!before.empty()) pieces[count++] = before;
  if (!after.empty()) pieces[count++] = after;
  return count;
}

/// The part of a line inside the infinite cylinder about z. Half-chord form of the quadratic: if the origin is close,
/// all terms are of the cylinder's size.
inline Span cylinder_span(const dvec3& origin, const dvec3& direction, double radius, int face) {
  const dvec2 o(origin), u(direction);
  const double a = glm::dot(u, u), b = glm::dot(o, u), moment = cross(o, u);
  // So nearly along the axis that the line needs 1e15 radii to leave: the squares would underflow.
  if (!(a > 1024 * std::numeric_limits<double>::min()))
    return glm::dot(o, o) <= radius * radius ? Span() : Span::nothing();
  const double discriminant = radius * radius * a - moment * moment;
  if (!(discriminant >= 0)) return Span::nothing();
  const double half = std::sqrt(discriminant);
  const double inverse = 1 / a;
  return {(-b - half) * inverse, (-b + half) * inverse, face, face};
}

/// Adds both ends of a span that bounds the solid, except on hidden faces. normal(face, p) is the gradient of a face at
/// p. Spans must come in rising order.
template <class Normal>
void add_hits(Hits& hits, const LocalRay& ray, const Span& span, unsigned hidden, const Normal& normal) {
  if (!span.bounded()) return;
  const auto add = [&](double s, int face) {
    if ((hidden >> face & 1u) != 0) return;
    const dvec3 n = normal(face, ray.at(s));
    // With g++, a ray at a sphere or cylinder takes half as long again if n is copied as a whole.
    hits.hit[hits.count++] = {ray.t(s), {n.x, n.y, n.z}, face};
  };
  add(span.from, span.from_face);
  add(span.to, span.to_face);
}

}  // namespace sightline::gpuprims
