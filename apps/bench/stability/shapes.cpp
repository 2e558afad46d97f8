#include "sightline/apps/bench/stability/shapes.h"

#include <algorithm>

namespace sightline::bench {
namespace {

using core::dvec2;
using core::dvec3;

enum class Where { kLateral, kEnd, kEdge };

dvec3 radial(double angle, double z = 0.0) {
  return {std::cos(angle), std::sin(angle), z};
}
dvec3 around(double angle) {
  return {-std::sin(angle), std::cos(angle), 0.0};
}
dvec3 unit(const dvec3& v) {
  const double length = glm::length(v);
  return length > 0.0 ? v / length : dvec3(0.0, 0.0, 1.0);
}
/// A random point of a disc.
dvec3 in_disc(double radius, Random& random) {
  return radius * std::sqrt(random.unit()) * radial(random.uniform(0.0, 2.0 * kPi));
}

/// A point on the circle of an end: flat inside, a rim at its edge.
SurfacePoint end_point(double radius, double z, double sign, Where where, const dvec3& outward, Random& random) {
  const dvec3 up(0.0, 0.0, sign);
  if (where == Where::kEnd) return {in_disc(radius, random) + dvec3(0.0, 0.0, z), up, {1.0, 0.0, 0.0}};
  const double angle = random.uniform(0.0, 2.0 * kPi);
  const dvec3 turned = outward.x * radial(angle) + dvec3(0.0, 0.0, outward.z);
  return {radius * radial(angle) + dvec3(0.0, 0.0, z), unit(turned + up), around(angle)};
}

SurfacePoint point_on(const core::Cylinder& c, Where where, Random& random) {
  const double angle = random.uniform(0.0, 2.0 * kPi), half = 0.5 * c.height, sign = random.sign();
  if (where != Where::kLateral) return end_point(c.radius, sign * half, sign, where, {1.0, 0.0, 0.0}, random);
  return {double(c.radius) * radial(angle) + dvec3(0, 0, random.uniform(-half, half)), radial(angle), around(angle)};
}

SurfacePoint point_on(const core::Snout& s, Where where, Random& random) {
  const double h = s.height, angle = random.uniform(0.0, 2.0 * kPi),
               slope = (double(s.top_radius) - s.bottom_radius) / h;
  const dvec3 lean(s.offset_x / h, s.offset_y / h, 1.0), e = radial(angle);
  const dvec3 normal = unit({e.x, e.y, -slope - e.x * lean.x - e.y * lean.y});
  // The ends are where the generator meets the (slanted) end planes.
  const auto end = [&](double sign) {
    const dvec2 m(std::tan(sign < 0 ? double(s.bottom_shear_x) : s.top_shear_x),
                  std::tan(sign < 0 ? double(s.bottom_shear_y) : s.top_shear_y));
    const double r = sign < 0 ? s.bottom_radius : s.top_radius, me = m.x * e.x + m.y * e.y;
    const double rise = r * me / (1.0 - m.x * lean.x - m.y * lean.y - slope * me);
    return SurfacePoint{lean * (sign * 0.5 * h + rise) + (r + slope * rise) * e, unit({-sign * m.x, -sign * m.y, sign}),
                        around(angle)};
  };
  if (where == Where::kLateral) {
    const dvec3 low = end(-1.0).point, high = end(1.0).point;
    return {low + random.unit() * (high - low), normal, around(angle)};
  }
  const double sign = random.sign();
  SurfacePoint p = end(sign);
  if (where == Where::kEdge) return {p.point, unit(normal + p.normal), p.along};
  const dvec3 centre = 0.5 * sign * h * lean;
  p.point = centre + random.unit() * (p.point - centre);
  return p;
}

SurfacePoint point_on(const core::CircularTorus& t, Where where, Random& random) {
  const double sweep = core::sweep_angle(t.angle);
  const bool whole = sweep == core::kFullTurn;
  const bool end = where != Where::kLateral && !whole;
  const double sign = random.sign();
  const double phi = end ? (sign < 0 ? 0.0 : sweep) : random.uniform(0.0, sweep);
  // A spindle has only the part away from the axis.
  const double open = t.major_radius < t.tube_radius ? std::acos(-double(t.major_radius) / t.tube_radius) : kPi;
  const double theta = random.uniform(-open, open), part = end && where == Where::kEnd ? std::sqrt(random.unit()) : 1.0;
  const dvec3 tube_normal = std::cos(theta) * radial(phi) + dvec3(0.0, 0.0, std::sin(theta));
  const dvec3 point = double(t.major_radius) * radial(phi) + part * t.tube_radius * tube_normal;
  const dvec3 along = -std::sin(theta) * radial(phi) + dvec3(0.0, 0.0, std::cos(theta));
  if (!end) return {point, tube_normal, along};
  const dvec3 outward = sign * around(phi);
  return {point, where == Where::kEnd ? outward : unit(outward + tube_normal), along};
}

SurfacePoint point_on(const core::RectangularTorus& t, Where where, Random& random) {
  const double sweep = core::sweep_angle(t.angle);
  const bool whole = sweep == core::kFullTurn;
  const double inner = std::min(t.inner_radius, t.outer_radius), outer = std::max(t.inner_radius, t.outer_radius);
  const double half = 0.5 * t.height, phi = random.uniform(0.0, sweep), z = random.uniform(-half, half);
  const double sign = random.sign(), up = random.sign(), wall = sign < 0 ? inner : outer;
  if (where == Where::kLateral) return {wall * radial(phi) + dvec3(0, 0, z), sign * radial(phi), around(phi)};
  const double across = random.uniform(inner, outer);
  const bool end = !whole && random.below(2) == 0;
  const double end_phi = up < 0 ? 0.0 : sweep;
  if (where == Where::kEnd) {
    if (end) return {across * radial(end_phi) + dvec3(0, 0, z), up * around(end_phi), {0, 0, 1}};
    return {across * radial(phi) + dvec3(0, 0, up * half), {0, 0, up}, around(phi)};
  }
  if (end) {
    const dvec3 point = wall * radial(end_phi) + dvec3(0, 0, z);
    return {point, unit(up * around(end_phi) + sign * radial(end_phi)), {0, 0, 1}};
  }
  return {wall * radial(phi) + dvec3(0, 0, up * half), unit(sign * radial(phi) + dvec3(0, 0, up)), around(phi)};
}

SurfacePoint point_on(const core::Sphere& s, Where, Random& random) {
  const dvec3 n = random.direction();
  return {0.5 * s.diameter * n, n, unit(glm::cross(n, std::fabs(n.z) < 0.5 ? dvec3(0, 0, 1) : dvec3(1, 0, 0)))};
}

SurfacePoint point_on(const core::EllipticalDish& d, Where where, Random& random) {
  const double angle = random.uniform(0.0, 2.0 * kPi), r = d.base_radius, h = d.height;
  if (where != Where::kLateral) return end_point(r, 0.0, -1.0, where, {1.0, 0.0, 0.0}, random);
  const double s = random.unit(), c = std::sqrt(1.0 - s * s);
  return {r * c * radial(angle) + dvec3(0, 0, h * s), unit(h * c * radial(angle) + dvec3(0, 0, r * s)), around(angle)};
}

SurfacePoint point_on(const core::SphericalDish& d, Where where, Random& random) {
  const double angle = random.uniform(0.0, 2.0 * kPi), r = d.base_radius, h = d.height;
  const double radius = 0.5 * (r * (r / h) + h), opening = 2.0 * std::atan2(h, r);
  const dvec3 rim_normal(std::sin(opening), 0.0, std::cos(opening));
  if (where != Where::kLateral) return end_point(r, 0.0, -1.0, where, rim_normal, random);
  const double theta = opening * std::sqrt(random.unit()), half = std::sin(0.5 * theta);
  const dvec3 normal = std::sin(theta) * radial(angle) + dvec3(0, 0, std::cos(theta));
  return {radius * std::sin(theta) * radial(angle) + dvec3(0, 0, h - 2.0 * radius * half * half), normal,
          around(angle)};
}

/// A point on a frustum with four sides, which includes boxes.
SurfacePoint point_on(const core::Pyramid& p, Where where, Random& random) {
  const double h = p.height;
  const auto corner = [&](double x, double y, double up) {
    const double ax = up < 0 ? p.bottom_x : p.top_x, ay = up < 0 ? p.bottom_y : p.top_y;
    return 0.5 * dvec3(x * ax + up * p.offset_x, y * ay + up * p.offset_y, up * h);
  };
  const double sign = random.sign(), up = random.sign(), s = random.unit(), t = random.unit();
  const bool x_side = random.below(2) == 0;
  const auto on_side = [&](double along, double z) { return x_side ? corner(sign, along, z) : corner(along, sign, z); };
  const dvec3 a = on_side(-1, -1), b = on_side(1, -1), c = on_side(-1, 1), d = on_side(1, 1);
  const dvec3 wide = glm::length(b - a) >= glm::length(d - c) ? b - a : d - c;
  dvec3 normal = unit(glm::cross(wide, 0.5 * (c + d) - 0.5 * (a + b)));
  if (glm::dot(normal, x_side ? dvec3(sign, 0, 0) : dvec3(0, sign, 0)) < 0.0) normal = -normal;
  const dvec3 low = a + s * (b - a), high = c + s * (d - c);
  if (where == Where::kLateral) return {low + t * (high - low), normal, unit(high - low)};
  if (where == Where::kEnd) {
    const dvec3 from = corner(-1, 2 * s - 1, up), to = corner(1, 2 * s - 1, up);
    return {from + t * (to - from), {0, 0, up}, {1, 0, 0}};
  }
  if (random.below(2)) return {up < 0 ? low : high, unit(normal + dvec3(0, 0, up)), unit(wide)};
  const dvec3 other = x_side ? dvec3(0, up, 0) : dvec3(up, 0, 0);
  const dvec3 from = up < 0 ? a : b, to = up < 0 ? c : d;
  return {from + t * (to - from), unit(normal + other), unit(to - from)};
}

SurfacePoint point_on(const core::Box& b, Where where, Random& random) {
  return point_on(core::Pyramid{b.size_x, b.size_y, b.size_x, b.size_y, 0.0f, 0.0f, b.size_z}, where, random);
}

SurfacePoint point_on(const core::Line& l, Where, Random& random) {
  return {{random.uniform(l.from, l.to), 0.0, 0.0}, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}};
}

SurfacePoint point_on(const core::Primitive& primitive, Where where, Random& random) {
  return std::visit([&](const auto& p) { return point_on(p, where, random); }, primitive);
}

}  // namespace

core::Primitive plain_shape(core::Kind kind, Random& random) {
  const auto f = [&](double low, double high) { return float(random.uniform(low, high)); };
  const auto sweep = [&] {  // the floats just below and above 2 pi are full turns
    if (random.below(4) != 0) return f(0.5, 6.2);
    return random.below(2) == 0 ? 6.2831855f : 6.283185f;
  };
  switch (kind) {
    case core::Kind::kPyramid:
      return core::Pyramid{f(0.5, 2), f(0.5, 2), f(0.2, 2), f(0.2, 2), f(-0.5, 0.5), f(-0.5, 0.5), f(0.5, 2)};
    case core::Kind::kBox:
      return core::Box{f(0.5, 2), f(0.5, 2), f(0.5, 2)};
    case core::Kind::kRectangularTorus:
      return core::RectangularTorus{f(0.5, 1.5), f(1.6, 2.5), f(0.5, 2), sweep()};
    case core::Kind::kCircularTorus:
      return core::CircularTorus{f(0.8, 2), f(0.3, 0.7), sweep()};
    case core::Kind::kEllipticalDish:
      return core::EllipticalDish{f(0.5, 2), f(0.3, 1.5)};
    case core::Kind::kSphericalDish:
      return core::SphericalDish{f(0.5, 2), f(0.3, 1.5)};
    case core::Kind::kSnout:
      return core::Snout{f(0.4, 1),    f(0.4, 1),    f(0.8, 3),    f(-0.5, 0.5), f(-0.5, 0.5),
                         f(-0.2, 0.2), f(-0.2, 0.2), f(-0.2, 0.2), f(-0.2, 0.2)};
    case core::Kind::kCylinder:
      return core::Cylinder{f(0.5, 2), f(0.5, 4)};
    case core::Kind::kSphere:
      return core::Sphere{f(0.5, 4)};
    default:
      return core::Line{0.0f, 1.0f};
  }
}

double radius_of(const core::Primitive& primitive) {
  struct Visitor {
    double operator()(const core::Pyramid& p) const {
      return 0.5 * std::max({p.bottom_x, p.bottom_y, p.top_x, p.top_y});
    }
    double operator()(const core::Box& b) const { return 0.5 * std::max(b.size_x, b.size_y); }
    double operator()(const core::RectangularTorus& t) const {
      return 0.5 * std::max(std::fabs(double(t.outer_radius) - t.inner_radius), double(t.height));
    }
    double operator()(const core::CircularTorus& t) const { return t.tube_radius; }
    double operator()(const core::EllipticalDish& d) const { return d.base_radius; }
    double operator()(const core::SphericalDish& d) const { return d.base_radius; }
    double operator()(const core::Snout& s) const { return std::max(s.bottom_radius, s.top_radius); }
    double operator()(const core::Cylinder& c) const { return c.radius; }
    double operator()(const core::Sphere& s) const { return 0.5 * s.diameter; }
    double operator()(const core::Line& l) const { return std::fabs(double(l.to) - l.from); }
  };
  return std::visit(Visitor{}, primitive);
}

SurfacePoint surface_point(const core::Primitive& primitive, Random& random) {
  return point_on(primitive, random.below(3) ? Where::kLateral : Where::kEnd, random);
}
SurfacePoint lateral_point(const core::Primitive& primitive, Random& random) {
  return point_on(primitive, Where::kLateral, random);
}
SurfacePoint edge_point(const core::Primitive& primitive, Random& random) {
  return point_on(primitive, Where::kEdge, random);
}

}  // namespace sightline::bench
