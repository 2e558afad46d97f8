// Random primitives and points of them, from the parametric form of each kind as the RVM format describes it: an
// independent twin of core/primitive.cpp for tests.
#pragma once

#include <cmath>
#include <initializer_list>
#include <numbers>
#include <random>
#include <vector>

#include "sightline/core/primitive.h"

namespace sightline::tests {

using Random = std::mt19937_64;

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Lengths over six orders of magnitude, so that needles and plates occur.
inline float random_length(Random& random) {
  return float(std::pow(10.0, uniform(random, -2.0, 4.0)));
}

/// A primitive with volume of what the functions give: lengths above 0, shifts of either sign, angles of tori. Snouts
/// have level ends.
template <class Length, class Shift, class Angle>
core::Primitive primitive_of(core::Kind kind, const Length& length, const Shift& shift, const Angle& angle) {
  switch (kind) {
    case core::Kind::kPyramid:
      return core::Pyramid{length(), length(), length(), length(), shift(), shift(), length()};
    case core::Kind::kBox:
      return core::Box{length(), length(), length()};
    case core::Kind::kRectangularTorus: {
      const float inner = length();
      return core::RectangularTorus{inner, inner + length(), length(), angle()};
    }
    case core::Kind::kCircularTorus:
      return core::CircularTorus{length(), length(), angle()};
    case core::Kind::kEllipticalDish:
      return core::EllipticalDish{length(), length()};
    case core::Kind::kSphericalDish:
      return core::SphericalDish{length(), length()};
    case core::Kind::kSnout:
      return core::Snout{length(), length(), length(), shift(), shift(), 0, 0, 0, 0};
    case core::Kind::kCylinder:
      return core::Cylinder{length(), length()};
    case core::Kind::kSphere:
      return core::Sphere{length()};
    default:
      return core::Line{shift(), shift()};
  }
}

inline core::Primitive random_primitive(core::Kind kind, Random& random) {
  return primitive_of(
      kind, [&] { return random_length(random); },
      [&] {
        const float share = float(uniform(random, -1.0, 1.0));
        return share * random_length(random);
      },
      [&] { return float(uniform(random, 1e-3, 2.0 * std::numbers::pi)); });
}

/// The point of a primitive at (a, b, c) in [0, 1]^3. Together the points cover every extreme of the solid.
struct PointAt {
  double a, b, c;
  using dvec3 = core::dvec3;
  static double turn(double t) { return 2.0 * std::numbers::pi * t; }
  /// (0, 1) widened so that both ends are met often, being where the extremes lie.
  static double ends(double t) { return std::min(1.0, std::max(0.0, 1.5 * t - 0.25)); }

  dvec3 operator()(const core::Pyramid& p) const {
    const double t = ends(c), x = (1 - t) * p.bottom_x + t * p.top_x, y = (1 - t) * p.bottom_y + t * p.top_y;
    return {(ends(a) - 0.5) * x + (t - 0.5) * p.offset_x, (ends(b) - 0.5) * y + (t - 0.5) * p.offset_y,
            (t - 0.5) * p.height};
  }
  dvec3 operator()(const core::Box& p) const {
    return {(ends(a) - 0.5) * p.size_x, (ends(b) - 0.5) * p.size_y, (ends(c) - 0.5) * p.size_z};
  }
  dvec3 operator()(const core::RectangularTorus& p) const {
    const double r = p.inner_radius + ends(b) * (double(p.outer_radius) - p.inner_radius), sweep = ends(a) * p.angle;
    return {r * std::cos(sweep), r * std::sin(sweep), (ends(c) - 0.5) * p.height};
  }
  dvec3 operator()(const core::CircularTorus& p) const {
    const double tube = ends(c) * p.tube_radius, sweep = ends(a) * p.angle;
    const double r = p.major_radius + tube * std::cos(turn(b));
    return {r * std::cos(sweep), r * std::sin(sweep), tube * std::sin(turn(b))};
  }
  dvec3 operator()(const core::EllipticalDish& p) const {
    const double polar = 0.5 * std::numbers::pi * ends(b), r = ends(c) * p.base_radius * std::cos(polar);
    return {r * std::cos(turn(a)), r * std::sin(turn(a)), ends(c) * p.height * std::sin(polar)};
  }
  dvec3 operator()(const core::SphericalDish& p) const {
    // By height z above the base: the circle there has radius sqrt(R^2 - (z - h + R)^2) = sqrt((h - z)(2R - h + z)).
    const double r = p.base_radius, h = p.height, sphere = (r * r + h * h) / (2.0 * h);
    const double z = h * (1.0 - ends(b) * ends(b)), circle = std::sqrt((h - z) * (2.0 * sphere - h + z));
    return {circle * std::cos(turn(a)), circle * std::sin(turn(a)), z};
  }
  dvec3 operator()(const core::Snout& p) const {
    const double t = ends(c), r = ends(b) * ((1 - t) * p.bottom_radius + t * p.top_radius);
    return {r * std::cos(turn(a)) + (t - 0.5) * p.offset_x, r * std::sin(turn(a)) + (t - 0.5) * p.offset_y,
            (t - 0.5) * p.height};
  }
  dvec3 operator()(const core::Cylinder& p) const {
    const double r = ends(b) * p.radius;
    return {r * std::cos(turn(a)), r * std::sin(turn(a)), (ends(c) - 0.5) * p.height};
  }
  dvec3 operator()(const core::Sphere& p) const {
    const double r = 0.5 * p.diameter, z = 2.0 * ends(b) - 1.0, circle = std::sqrt(1.0 - z * z);
    return r * dvec3(circle * std::cos(turn(a)), circle * std::sin(turn(a)), z);
  }
  dvec3 operator()(const core::Line& p) const { return {p.from + ends(a) * (double(p.to) - p.from), 0.0, 0.0}; }
};

inline core::dvec3 point_at(const core::Primitive& primitive, double a, double b, double c) {
  return std::visit(PointAt{a, b, c}, primitive);
}

inline core::dvec3 random_point(const core::Primitive& primitive, Random& random) {
  const double a = uniform(random, 0, 1), b = uniform(random, 0, 1), c = uniform(random, 0, 1);
  return point_at(primitive, a, b, c);
}

inline core::dvec3 random_direction(Random& random) {
  std::normal_distribution<double> normal;
  core::dvec3 v;
  do {
    for (int i = 0; i < 3; ++i) v[i] = normal(random);
  } while (glm::length(v) < 1e-3);
  return glm::normalize(v);
}

/// Rotation with scale, shear or mirror.
inline core::Affine random_affine(Random& random, double size, double distance) {
  core::Affine a;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) a.linear[c][r] = uniform(random, -size, size);
  for (int r = 0; r < 3; ++r) a.origin[r] = uniform(random, -distance, distance);
  return a;
}

/// Rotation about a random axis.
inline core::dmat3 random_rotation(Random& random) {
  const core::dvec3 z = random_direction(random);
  core::dvec3 x = glm::cross(random_direction(random), z);
  while (glm::length(x) < 1e-3) x = glm::cross(random_direction(random), z);
  x = glm::normalize(x);
  return {x, glm::cross(z, x), z};
}

}  // namespace sightline::tests
