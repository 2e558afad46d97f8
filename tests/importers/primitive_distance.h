// How far a point lies outside analytic primitives, and their volumes, straight from their definitions in
// core/primitive.h: the slow twin of what makes them.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>
#include <variant>

#include "sightline/core/affine.h"
#include "sightline/core/primitive.h"

namespace sightline::tests {

/// The largest signed distance to the surfaces that bound a primitive, in its units, negative within it: 0 exactly on
/// its surface, and outside never more than the distance to it. Snouts must have no offset.
inline double outside(const core::Primitive& primitive, const core::dvec3& p) {
  const double aside = std::hypot(p.x, p.y);
  const auto slab = [](double at, double size) { return std::abs(at) - 0.5 * size; };
  // Beyond the two planes through the z axis that bound a sweep from +X.
  const auto beyond = [&](float angle) {
    const double sweep = core::sweep_angle(angle);
    if (sweep == core::kFullTurn) return -std::numeric_limits<double>::infinity();
    const double begin = -p.y, end = std::cos(sweep) * p.y - std::sin(sweep) * p.x;
    return sweep <= std::numbers::pi ? std::max(begin, end) : std::min(begin, end);
  };
  return std::visit(
      [&](const auto& as) -> double {
        using T = std::decay_t<decltype(as)>;
        if constexpr (std::is_same_v<T, core::Box>) {
          return std::max({slab(p.x, as.size_x), slab(p.y, as.size_y), slab(p.z, as.size_z)});
        } else if constexpr (std::is_same_v<T, core::Pyramid>) {
          const double t = p.z / as.height + 0.5;  // 0 at the bottom, 1 at the top
          const auto side = [&](double at, double bottom, double top, double offset) {
            const double centre = (t - 0.5) * offset, half = 0.5 * ((1.0 - t) * bottom + t * top);
            const double low = (centre - half) - at, high = at - (centre + half);
            const double slope_low = (offset - 0.5 * (top - bottom)) / as.height,
                         slope_high = (offset + 0.5 * (top - bottom)) / as.height;
            return std::max(low / std::hypot(1.0, slope_low), high / std::hypot(1.0, slope_high));
          };
          return std::max({slab(p.z, as.height), side(p.x, as.bottom_x, as.top_x, as.offset_x),
                           side(p.y, as.bottom_y, as.top_y, as.offset_y)});
        } else if constexpr (std::is_same_v<T, core::Cylinder>) {
          return std::max(aside - as.radius, slab(p.z, as.height));
        } else if constexpr (std::is_same_v<T, core::Sphere>) {
          return glm::length(p) - 0.5 * as.diameter;
        } else if constexpr (std::is_same_v<T, core::SphericalDish>) {
          const double r = double(as.base_radius), h = as.height, radius = (r * r + h * h) / (2.0 * h);
          return std::max(glm::length(p - core::dvec3(0, 0, h - radius)) - radius, -p.z);
        } else if constexpr (std::is_same_v<T, core::CircularTorus>) {
          return std::max(std::hypot(aside - as.major_radius, p.z) - as.tube_radius, beyond(as.angle));
        } else if constexpr (std::is_same_v<T, core::RectangularTorus>) {
          return std::max({aside - as.outer_radius, as.inner_radius - aside, slab(p.z, as.height), beyond(as.angle)});
        } else if constexpr (std::is_same_v<T, core::Snout>) {
          const double slope = (double(as.top_radius) - double(as.bottom_radius)) / as.height;
          const double radius = 0.5 * (double(as.top_radius) + double(as.bottom_radius)) + slope * p.z;
          const auto above = [&](double centre, double shear_x, double shear_y) {
            const double x = std::tan(shear_x), y = std::tan(shear_y);
            return (p.z - centre - x * p.x - y * p.y) / std::sqrt(1.0 + x * x + y * y);
          };
          return std::max({(aside - radius) / std::hypot(1.0, slope),
                           above(0.5 * as.height, as.top_shear_x, as.top_shear_y),
                           -above(-0.5 * as.height, as.bottom_shear_x, as.bottom_shear_y)});
        } else {
          return std::numeric_limits<double>::infinity();
        }
      },
      primitive);
}

inline double volume(const core::Primitive& primitive) {
  constexpr double kPi = std::numbers::pi;
  return std::visit(
      [&](const auto& as) -> double {
        using T = std::decay_t<decltype(as)>;
        if constexpr (std::is_same_v<T, core::Box>) {
          return double(as.size_x) * as.size_y * as.size_z;
        } else if constexpr (std::is_same_v<T, core::Pyramid>) {
          const double bx = as.bottom_x, by = as.bottom_y, tx = as.top_x, ty = as.top_y;
          return as.height * (bx * by / 3.0 + (bx * ty + tx * by) / 6.0 + tx * ty / 3.0);
        } else if constexpr (std::is_same_v<T, core::Cylinder>) {
          return kPi * as.radius * as.radius * double(as.height);
        } else if constexpr (std::is_same_v<T, core::Sphere>) {
          return kPi / 6.0 * std::pow(double(as.diameter), 3);
        } else if constexpr (std::is_same_v<T, core::SphericalDish>) {
          const double r = double(as.base_radius), h = as.height;
          return kPi * h / 6.0 * (3.0 * r * r + h * h);
        } else if constexpr (std::is_same_v<T, core::CircularTorus>) {
          return core::sweep_angle(as.angle) * as.major_radius * kPi * as.tube_radius * as.tube_radius;
        } else if constexpr (std::is_same_v<T, core::RectangularTorus>) {
          const double inner = as.inner_radius, outer = as.outer_radius;
          return 0.5 * core::sweep_angle(as.angle) * (outer * outer - inner * inner) * as.height;
        } else if constexpr (std::is_same_v<T, core::Snout>) {
          const double r0 = as.bottom_radius, r1 = as.top_radius, h = as.height, slope = (r1 - r0) / h;
          if (slope == 0.0) return kPi * r0 * r0 * h;
          // From the apex, a cone over the region that a plane cuts out; its area by integrating over all directions.
          const auto to_apex = [&](double radius, double shear_x, double shear_y) {
            constexpr int kDirections = 4096;
            double area = 0.0;
            for (int i = 0; i < kDirections; ++i) {
              const double angle = 2.0 * kPi * i / kDirections;
              const double lean = std::tan(shear_x) * std::cos(angle) + std::tan(shear_y) * std::sin(angle);
              area += kPi / kDirections * std::pow(radius / (1.0 - slope * lean), 2);
            }
            return area * radius / slope / 3.0;
          };
          return to_apex(r1, as.top_shear_x, as.top_shear_y) - to_apex(r0, as.bottom_shear_x, as.bottom_shear_y);
        } else {
          return 0.0;
        }
      },
      primitive);
}

}  // namespace sightline::tests
