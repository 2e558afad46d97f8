#include "sightline/importers/recognise/internal/shape_fit.h"

#include <algorithm>
#include <cmath>

#include "sightline/core/surface_area.h"
#include "sightline/importers/recognise/internal/surface_distance.h"

namespace sightline::importers::recognition {
namespace {

/// Vertices may be off by this share of the sagitta: less than the tessellation itself is.
constexpr double kShareOfSagitta = 0.1;
/// What grid noise may explain at most, as shares of the sagitta and of the radius.
constexpr double kGridOfSagitta = 0.5, kGridOfRadius = 0.004;
/// A surface fitted to vertices that are off is off itself.
constexpr double kFitted = 1.5;
/// No vertex may be farther off than this share of the radius, whatever explains it.
constexpr double kMostOfRadius = 0.02;
/// Inscribed polyhedra have less area than their surface: a circle of eight segments has 90 % of it.
constexpr double kLeastArea = 0.75, kMostArea = 1.05;

}  // namespace

double Allowance::vertex(double radius, double sagitta) const {
  if (chosen > 0.0) return std::min(chosen, 0.1 * radius);
  const double grid = std::min(kFitted * noise.grid, std::max(kGridOfSagitta * sagitta, kGridOfRadius * radius));
  return std::min(std::max({2.0 * noise.rounding, kShareOfSagitta * sagitta, grid}), kMostOfRadius * radius);
}

double Allowance::same(double radius, double sagitta, double residual) const {
  const double grid = std::min(noise.grid, std::max(kGridOfSagitta * sagitta, kGridOfRadius * radius));
  return 2.0 * std::max({noise.rounding, residual, grid});
}

bool verify(const Solid& solid, double vertex, double explained, double covered, double rim, Found& found) {
  for (const float value : core::parameters(found.primitive))
    if (!std::isfinite(value)) return false;
  const core::Affine& place = found.mesh_from_primitive;
  if (!core::is_finite(place)) return false;
  const core::dmat3 turn = glm::transpose(place.linear);  // a rotation
  const auto local = [&](const dvec3& p) { return turn * (p - place.origin); };
  const SurfaceDistance distance = surface_distance(found.primitive);
  double worst = 0.0, residual = 0.0, area = 0.0;
  for (const std::uint32_t t : found.triangles) {
    const dvec3 a = local(solid.points[solid.corners[3 * t]]), b = local(solid.points[solid.corners[3 * t + 1]]),
                c = local(solid.points[solid.corners[3 * t + 2]]);
    for (const dvec3& p : {a, b, c}) {
      const double off = distance(p);
      if (!(off <= vertex)) return false;
      residual = std::max(residual, off);
    }
    for (const dvec3& p : {0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (a + b + c) / 3.0}) {
      const double off = distance(p);
      if (!(off <= vertex + explained)) return false;
      worst = std::max(worst, off);
    }
    area += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  found.deviation = std::max(worst, residual + rim);
  // Chords are off across the axis alone where all sides are parallel to it.
  const bool prism = std::holds_alternative<core::Cylinder>(found.primitive) ||
                     std::holds_alternative<core::RectangularTorus>(found.primitive);
  found.along = prism ? residual : found.deviation;
  found.residual = residual;
  const double whole = core::surface_area(found.primitive);
  return area + covered >= kLeastArea * whole && area + covered <= kMostArea * whole;
}

core::dmat3 axes_along(const dvec3& axis, const dvec3& towards) {
  dvec3 x = towards - glm::dot(towards, axis) * axis;
  if (!(glm::dot(x, x) > 1e-12 * glm::dot(towards, towards))) {
    const dvec3 size = glm::abs(axis);
    const dvec3 other = size.x <= size.y && size.x <= size.z ? dvec3(1, 0, 0)
                        : size.y <= size.z                   ? dvec3(0, 1, 0)
                                                             : dvec3(0, 0, 1);
    x = other - glm::dot(other, axis) * axis;
  }
  x = glm::normalize(x);
  return {x, glm::cross(axis, x), axis};
}

std::optional<dvec3> solve(core::dmat3 a, dvec3 b) {
  // glm keeps columns: a[column][row].
  const double det = glm::determinant(a);
  double scale = 1.0;
  for (int i = 0; i < 3; ++i) scale *= glm::length(a[i]);
  if (!(std::fabs(det) > 1e-12 * scale)) return {};
  return glm::inverse(a) * b;
}

std::optional<Circle> fit_circle(const std::vector<core::dvec2>& points) {
  if (points.size() < 3) return {};
  core::dvec2 mean(0.0);
  for (const auto& p : points) mean += p;
  mean /= double(points.size());
  double xx = 0, xy = 0, yy = 0, xs = 0, ys = 0, s = 0;
  for (const auto& q : points) {
    const core::dvec2 p = q - mean;
    const double squared = glm::dot(p, p);
    xx += p.x * p.x, xy += p.x * p.y, yy += p.y * p.y, xs += p.x * squared, ys += p.y * squared, s += squared;
  }
  const double det = xx * yy - xy * xy;
  if (!(det > 1e-10 * (xx + yy) * (xx + yy))) return {};
  const core::dvec2 centre(0.5 * (xs * yy - ys * xy) / det, 0.5 * (ys * xx - xs * xy) / det);
  return Circle{mean + centre, std::sqrt(s / double(points.size()) + glm::dot(centre, centre))};
}

}  // namespace sightline::importers::recognition
