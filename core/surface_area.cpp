#include "sightline/core/surface_area.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <variant>

namespace sightline::core {
namespace {

double quadrangle(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& d) {
  return 0.5 * glm::length(glm::cross(c - a, d - b));
}

double area_of(const Pyramid& p) {
  dvec3 corners[2][4];
  for (int end = 0; end < 2; ++end) {
    const double sign = end == 0 ? -0.5 : 0.5, x = 0.5 * double(end == 0 ? p.bottom_x : p.top_x),
                 y = 0.5 * double(end == 0 ? p.bottom_y : p.top_y);
    const dvec3 middle = sign * dvec3(p.offset_x, p.offset_y, p.height);
    for (int i = 0; i < 4; ++i) corners[end][i] = middle + dvec3(i == 1 || i == 2 ? x : -x, i >= 2 ? y : -y, 0.0);
  }
  double sum = quadrangle(corners[0][0], corners[0][1], corners[0][2], corners[0][3]) +
               quadrangle(corners[1][0], corners[1][1], corners[1][2], corners[1][3]);
  for (int i = 0; i < 4; ++i) {
    const int next = (i + 1) % 4;
    sum += quadrangle(corners[0][i], corners[0][next], corners[1][next], corners[1][i]);
  }
  return sum;
}

double area_of(const Box& b) {
  const double x = std::abs(b.size_x), y = std::abs(b.size_y), z = std::abs(b.size_z);
  return 2.0 * (x * y + y * z + z * x);
}

double area_of(const RectangularTorus& t) {
  const double inner = std::abs(t.inner_radius), outer = std::abs(t.outer_radius), height = std::abs(t.height);
  const double sweep = sweep_angle(t.angle), thick = std::abs(outer - inner);
  const double ends = sweep < kFullTurn ? 2.0 * thick * height : 0.0;
  return sweep * (inner + outer) * (height + thick) + ends;
}

double area_of(const CircularTorus& t) {
  const double tube = std::abs(t.tube_radius), sweep = sweep_angle(t.angle);
  const double ends = sweep < kFullTurn ? 2.0 * std::numbers::pi * tube * tube : 0.0;
  return sweep * std::abs(double(t.major_radius)) * 2.0 * std::numbers::pi * tube + ends;
}

/// Half of Thomsen's formula for the ellipsoid, off by 1 % at most.
double area_of(const EllipticalDish& d) {
  constexpr double kPower = 1.6075;
  const double r = std::abs(d.base_radius), h = std::abs(d.height);
  const double both = std::pow(r * r, kPower), sides = std::pow(r * h, kPower);
  return 2.0 * std::numbers::pi * std::pow((both + 2.0 * sides) / 3.0, 1.0 / kPower) + std::numbers::pi * r * r;
}

double area_of(const SphericalDish& d) {
  const double r = d.base_radius, h = d.height;
  return std::numbers::pi * (2.0 * r * r + h * h);
}

double area_of(const Snout& s) {
  const double bottom = std::abs(s.bottom_radius), top = std::abs(s.top_radius);
  const double length = glm::length(dvec3(s.offset_x, s.offset_y, s.height));
  return std::numbers::pi * ((bottom + top) * std::hypot(bottom - top, length) + bottom * bottom + top * top);
}

double area_of(const Cylinder& c) {
  const double r = std::abs(c.radius), h = std::abs(c.height);
  return 2.0 * std::numbers::pi * r * (r + h);
}

double area_of(const Sphere& s) {
  return std::numbers::pi * double(s.diameter) * double(s.diameter);
}

double area_of(const Line&) {
  return 0.0;
}

}  // namespace

double surface_area(const Primitive& primitive) {
  return std::visit([](const auto& p) { return area_of(p); }, primitive);
}

double surface_area(const Mesh& mesh) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const dvec3 a(mesh.positions[mesh.indices[i]]), b(mesh.positions[mesh.indices[i + 1]]),
        c(mesh.positions[mesh.indices[i + 2]]);
    sum += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return sum;
}

}  // namespace sightline::core
