#include "sightline/gpuprims/internal/dome.h"

#include "sightline/gpuprims/internal/local_ray.h"

namespace sightline::gpuprims {
namespace {

/// x^2 + y^2 <= (1 - g) (radius^2 + bulge^2 g) with g = z / height, as dome.h has it.
struct Dome {
  double base, bulge, stretch;  ///< radius^2, bulge^2, 1 / height

  Span span(const dvec3& o, const dvec3& u) const {
    const double g = stretch * o.z, climb = stretch * u.z;
    const double a = u.x * u.x + u.y * u.y + bulge * climb * climb;
    const double b = o.x * u.x + o.y * u.y + climb * ((base - bulge) / 2 + bulge * g);
    const double c = o.x * o.x + o.y * o.y - (1 - g) * (base + bulge * g);
    const double discriminant = b * b - a * c;
    if (!(discriminant >= 0)) return Span::nothing();
    const double q = -(b + std::copysign(std::sqrt(discriminant), b));
    const double near_root = q == 0 ? 0 : c / q, far_root = q / a;
    return {std::min(near_root, far_root), std::max(near_root, far_root), kSide, kSide};
  }

  dvec3 normal(int face, const dvec3& p) const {
    if (face != kSide) return {0, 0, -1};
    return {p.x, p.y, stretch * ((base - bulge) / 2 + bulge * stretch * p.z)};
  }
};

}  // namespace

Hits intersect_dome(const Ray& ray, double radius, double bulge, double height, bool whole, Caps caps) {
  Hits hits;
  const double size = std::max(radius, bulge), scale = inverse_power_of_two(size);
  const auto local = closest_approach(ray, {1.0, 1.0, weight(size, height)}, size);
  if (!local.valid) return hits;
  const double base = scale * radius, side = scale * bulge;
  const Dome dome{base * base, side * side, 1.0 / (scale * height)};
  Span span = dome.span(local.origin, local.direction);
  if (!whole) span.clip(local.origin.z, local.direction.z, kBottom);
  add_hits(hits, local, span, internal_faces(caps), [&](int face, const dvec3& p) { return dome.normal(face, p); });
  return hits;
}

}  // namespace sightline::gpuprims
