// Common form of the sphere and both dishes: a quadric of revolution, cut at its base. Internal to gpuprims.
#pragma once

#include "sightline/gpuprims/internal/local_ray.h"

namespace sightline::gpuprims {

/// x^2 + y^2 <= (1 - g) (radius^2 + bulge^2 g) with g = z / height, which is
///   half an ellipsoid above z = 0  with bulge = radius,
///   the cap of a sphere            with bulge = height (and no centre far below, from which a flat cap would lose all
///                                  precision).
template <class Real>
struct Dome {
  Real base, bulge, stretch;  ///< radius^2, bulge^2, 1 / height

  Span<Real> span(const Vec3<Real>& o, const Vec3<Real>& u) const {
    const Real g = stretch * o.z, climb = stretch * u.z;
    const Real a = u.x * u.x + u.y * u.y + bulge * climb * climb;
    const Real b = o.x * u.x + o.y * u.y + climb * ((base - bulge) / 2 + bulge * g);
    const Real c = o.x * o.x + o.y * o.y - (1 - g) * (base + bulge * g);
    const Real discriminant = b * b - a * c;
    if (!(discriminant >= 0)) return Span<Real>::nothing();
    const Real q = -(b + std::copysign(std::sqrt(discriminant), b));
    const Real near_root = q == 0 ? 0 : c / q, far_root = q / a;
    return {std::min(near_root, far_root), std::max(near_root, far_root), kLateral, kLateral};
  }

  Vec3<Real> normal(int face, const Vec3<Real>& p) const {
    if (face != kLateral) return {0, 0, -1};
    return {p.x, p.y, stretch * ((base - bulge) / 2 + bulge * stretch * p.z)};
  }
};

/// A dome flatter than this times its radius is a two-sided disc.
inline constexpr double kFlatDome = 1e-18;

/// Needs radius >= 0, bulge > 0 and height > kFlatDome * radius, all finite. `whole`: not cut at the base.
template <class Real>
Hits intersect_dome(const Ray& ray, double radius, double bulge, double height, bool whole, Caps caps) {
  Hits hits;
  const double size = std::max(radius, bulge), scale = inverse_power_of_two(size);
  const auto local = closest_approach<Real>(ray, {1.0, 1.0, weight(size, height)}, size);
  if (!local.valid) return hits;
  const double base = scale * radius, side = scale * bulge;
  const Dome<Real> dome{Real(base * base), Real(side * side), Real(1.0 / (scale * height))};
  Span<Real> span = dome.span(local.origin, local.direction);
  if (!whole) span.clip(local.origin.z, local.direction.z, kBottom);
  add_hits(hits, local, span, hidden_faces(caps), [&](int face, const Vec3<Real>& p) { return dome.normal(face, p); });
  return hits;
}

}  // namespace sightline::gpuprims
