#include "sightline/raytrace/internal/ray_frame.h"

#include <algorithm>
#include <cmath>

namespace sightline::raytrace {
namespace {

/// z at the point of a triangle's outline that is nearest to the origin.
double nearest_edge(const double (&x)[3], const double (&y)[3], const double (&z)[3]) {
  double least = std::numeric_limits<double>::infinity(), result = z[0];
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    const double ex = x[b] - x[a], ey = y[b] - y[a], square = ex * ex + ey * ey;
    const double part = square > 0.0 ? std::clamp(-(x[a] * ex + y[a] * ey) / square, 0.0, 1.0) : 0.0;
    const double px = x[a] + part * ex, py = y[a] + part * ey, away = px * px + py * py;
    if (away < least) least = away, result = z[a] + part * (z[b] - z[a]);
  }
  return result;
}

}  // namespace

TreeSpace space_around(const core::AabbD& box) {
  if (box.empty()) return {};
  TreeSpace space;
  space.centre = box.centre();
  space.half = 0.5 * box.size();
  space.radius = glm::length(space.half);
  const dvec3 c = glm::abs(space.centre);
  space.reach = std::max(c.x, std::max(c.y, c.z)) + 5.0 * space.radius + 1e-30;
  return space;
}

bool enter_scaled(const TreeSpace& space, const dvec3& origin, const dvec3& direction, double t_min, double t_max,
                  RayFrame& frame) {
  const double longest = std::max(std::fabs(direction.x), std::max(std::fabs(direction.y), std::fabs(direction.z)));
  if (!(longest > 0.0) || space.radius < 0.0) return false;
  const double factor = inverse_power_of_two(longest), per_factor = power_of_two(longest);
  const bool near = enter(space, origin, factor * direction, t_min * per_factor, t_max * per_factor, frame);
  frame.factor *= factor;
  frame.per_factor *= per_factor;
  return near;
}

double crossing(const RayFrame& frame, const dvec3 (&corners)[3]) {
  const Axes axes(frame.direction);
  const double d[3] = {frame.direction.x, frame.direction.y, frame.direction.z};
  const double along = 1.0 / d[axes.z], shear_x = d[axes.x] * along, shear_y = d[axes.y] * along;
  const double per_square = 1.0 / (d[axes.x] * d[axes.x] + d[axes.y] * d[axes.y] + d[axes.z] * d[axes.z]);
  double x[3], y[3], z[3];
  for (int i = 0; i < 3; ++i) {
    const dvec3 to = corners[i] - frame.origin;
    const double v[3] = {to.x, to.y, to.z};
    x[i] = v[axes.x] - shear_x * v[axes.z];
    y[i] = v[axes.y] - shear_y * v[axes.z];
    z[i] = per_square * (v[axes.x] * d[axes.x] + v[axes.y] * d[axes.y] + v[axes.z] * d[axes.z]);
  }
  const double u = x[2] * y[1] - y[2] * x[1], v = x[0] * y[2] - y[0] * x[2], w = x[1] * y[0] - y[1] * x[0];
  const double sum = u + v + w;
  const bool inside = std::min(u, std::min(v, w)) >= 0.0 || std::max(u, std::max(v, w)) <= 0.0;
  return inside && sum != 0.0 ? (u * z[0] + v * z[1] + w * z[2]) / sum : nearest_edge(x, y, z);
}

}  // namespace sightline::raytrace
