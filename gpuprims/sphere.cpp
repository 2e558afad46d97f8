#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sightline/gpuprims/internal/dome.h"
#include "sightline/gpuprims/internal/mesh_builder.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims {

Hits intersect(const core::Sphere& sphere, const Ray& ray, Caps /*caps*/) {
  const double radius = 0.5 * std::fabs(sphere.diameter);
  if (!(radius > 0.0 && std::isfinite(radius))) return {};
  return intersect_dome(ray, radius, radius, radius, true, {});
}

core::Mesh tessellate(const core::Sphere& sphere, const Tessellation& config, Caps /*caps*/) {
  const double radius = 0.5 * std::fabs(sphere.diameter);
  if (!(radius > 0.0 && std::isfinite(radius))) return {};
  const int columns = segment_count(config, radius, 2.0 * std::numbers::pi);
  const int rows = std::max(2, segment_count(config, radius, std::numbers::pi));
  const std::vector<dvec2> around = arc_points(columns, 2.0 * std::numbers::pi);
  std::vector<dvec2> meridian = arc_points(rows, std::numbers::pi);
  meridian.back() = {-1.0, 0.0};  // a pole is one point, not a ring of rounding errors

  MeshBuilder builder;
  builder.add_grid(rows, columns, [&](int row, int column) {
    const dvec3 direction(meridian[row].y * around[column], -meridian[row].x);
    return Vertex{radius * direction, direction};
  });
  return builder.finish();
}

}  // namespace sightline::gpuprims
