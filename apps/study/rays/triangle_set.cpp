#include "sightline/apps/study/rays/triangle_set.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace sightline::study::rays {

using core::Aabb;
using core::dvec3;
using core::vec3;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool finite(const dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

double largest(const dvec3& v) {
  return std::max({v.x, v.y, v.z});
}

bool usable(const Ray& ray) {
  return finite(ray.origin) && finite(ray.direction) && largest(glm::abs(ray.direction)) >= Ray::kLeastDirection &&
         ray.t_max >= 0.0;
}

vec3 lowest(const TriangleSet::Corners& c) {
  return glm::min(glm::min(c[0], c[1]), c[2]);
}

vec3 highest(const TriangleSet::Corners& c) {
  return glm::max(glm::max(c[0], c[1]), c[2]);
}

}  // namespace

UnitRay::UnitRay(const UnitSpace& space, const Ray& ray) {
  if (space.bounds.empty() || !usable(ray)) return;
  const double length = largest(glm::abs(ray.direction));
  const dvec3 from = space.from_scene(ray.origin);
  const dvec3 normalised = (1.0 / length) * ray.direction;
  dvec3 to, per;
  scale = length / space.size;
  double leave = ray.t_max * scale;
  for (int a = 0; a < 3; ++a) {
    to[a] = std::copysign(std::max(std::abs(normalised[a]), kLeastDirection), normalised[a]);
    per[a] = 1.0 / to[a];
    const double low = (double(space.bounds.min[a]) - from[a]) * per[a];
    const double high = (double(space.bounds.max[a]) - from[a]) * per[a];
    entry = std::max(entry, std::min(low, high));
    leave = std::min(leave, std::max(low, high));
  }
  if (!(entry <= leave)) return;
  exit = float(leave - entry);
  origin = glm::clamp(vec3(from + entry * to), space.bounds.min, space.bounds.max);
  direction = vec3(to);
  inverse = vec3(per);
}

ShearedRay::ShearedRay(const Ray& ray) : origin(ray.origin), direction(ray.direction) {
  const dvec3 size = glm::abs(direction);
  z = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
  x = (z + 1) % 3;
  y = (x + 1) % 3;
  const double per_z = 1.0 / direction[z];
  shear = {direction[x] * per_z, direction[y] * per_z, per_z};
}

TriangleSet::TriangleSet(std::span<const vec3> positions, std::span<const std::uint32_t> indices) {
  assert(indices.size() % 3 == 0 && indices.size() / 3 < core::kNone);
  corners_.resize(indices.size() / 3);
  core::AabbD bounds;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const vec3& p = positions[indices[i]];
    assert(finite(dvec3(p)));
    corners_[i / 3][i % 3] = p;
    bounds.grow(dvec3(p));
  }
  if (corners_.empty()) return;
  space_.corner = bounds.min;
  space_.size = largest(bounds.size());
  if (space_.size == 0.0) space_.size = 1.0;
  space_.bounds = {vec3(0.0f) - UnitSpace::kSlack, vec3(space_.from_scene(bounds.max)) + UnitSpace::kSlack};
}

std::vector<Aabb> TriangleSet::boxes() const {
  std::vector<Aabb> result(corners_.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const Corners& c = corners_[i];
    result[i].min = vec3(space_.from_scene(dvec3(lowest(c)))) - UnitSpace::kSlack;
    result[i].max = vec3(space_.from_scene(dvec3(highest(c)))) + UnitSpace::kSlack;
  }
  return result;
}

double TriangleSet::intersect(const ShearedRay& ray, std::uint32_t triangle, double t_max) const {
  const Corners& corners = corners_[triangle];
  // Each corner in the ray's own space, where the ray runs along z. The result depends on the corner and the ray alone,
  // and every product below has its mirror image in the neighbour that shares the edge: hence watertight.
  std::array<double, 3> px, py, pz;
  for (int i = 0; i < 3; ++i) {
    const dvec3 p = dvec3(corners[i]) - ray.origin;
    px[i] = p[ray.x] - ray.shear.x * p[ray.z];
    py[i] = p[ray.y] - ray.shear.y * p[ray.z];
    pz[i] = ray.shear.z * p[ray.z];
  }
  const double u = px[2] * py[1] - py[2] * px[1];
  const double v = px[0] * py[2] - py[0] * px[2];
  const double w = px[1] * py[0] - py[1] * px[0];
  if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return kInfinity;
  const double determinant = u + v + w;
  if (determinant == 0.0) return kInfinity;
  const double t = (u * pz[0] + v * pz[1] + w * pz[2]) / determinant;
  if (!(t >= 0.0 && t <= t_max && t < kInfinity)) return kInfinity;

  // Weights of a triangle that the ray sees edge-on are rounding errors, and t is anywhere. Such a hit counts only
  // where the triangle can be.
  const dvec3 point = ray.origin + t * ray.direction;
  const double slack = 0.5 * double(UnitSpace::kSlack) * space_.size;
  const dvec3 low = dvec3(lowest(corners)) - slack, high = dvec3(highest(corners)) + slack;
  const bool inside = glm::all(glm::greaterThanEqual(point, low)) && glm::all(glm::lessThanEqual(point, high));
  return inside ? t : kInfinity;
}

Hit TriangleSet::brute_force(const Ray& ray) const {
  Hit hit;
  if (!usable(ray)) return hit;
  const ShearedRay sheared(ray);
  for (std::uint32_t i = 0; i < size(); ++i) {
    const double t = intersect(sheared, i, ray.t_max);
    if (t < hit.t) hit = {t, i};
  }
  return hit;
}

}  // namespace sightline::study::rays
