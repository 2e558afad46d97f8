#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sightline/gpuprims/internal/dome.h"
#include "sightline/gpuprims/internal/mesh_builder.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims {

Hits intersect(const core::EllipticalDish& dish, const Ray& ray, Caps caps) {
  const double radius = std::fabs(dish.base_radius), height = std::fabs(dish.height);
  if (!(radius > 0.0 && std::isfinite(radius + height))) return {};
  if (height <= kFlatDome * radius) return intersect(core::Cylinder{dish.base_radius, 0.0f}, ray, {caps.bottom, true});
  return intersect_dome(ray, radius, radius, height, false, caps);
}

core::Mesh tessellate(const core::EllipticalDish& dish, const Tessellation& config, Caps caps) {
  constexpr double kHalfTurn = std::numbers::pi;
  const double radius = std::fabs(dish.base_radius), height = std::fabs(dish.height);
  if (!(radius > 0.0 && std::isfinite(radius + height))) return {};
  const int columns = segment_count(config, radius, 2.0 * kHalfTurn);
  // An ellipse is a squeezed circle of its larger axis, and squeezing only shrinks chord errors.
  const int rows = segment_count(config, std::max(radius, height), 0.5 * kHalfTurn);
  const std::vector<dvec2> around = arc_points(columns, 2.0 * kHalfTurn);
  std::vector<dvec2> meridian = arc_points(rows, 0.5 * kHalfTurn);
  meridian.back() = {0.0, 1.0};  // a pole is one point, not a ring of rounding errors

  MeshBuilder builder;
  builder.add_grid(rows, columns, [&](int row, int column) {
    const dvec2& m = meridian[row];
    return Vertex{dvec3(radius * m.x * around[column], height * m.y),
                  dvec3(height * m.x * around[column], radius * m.y)};
  });
  if (caps.bottom) builder.add_disc(around, radius, 0.0, -1.0);
  return builder.finish();
}

}  // namespace sightline::gpuprims
