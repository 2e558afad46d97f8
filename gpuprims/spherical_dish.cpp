#include <cmath>
#include <numbers>
#include <vector>

#include "sightline/gpuprims/internal/dome.h"
#include "sightline/gpuprims/internal/mesh_builder.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims {

Hits intersect(const core::SphericalDish& dish, const Ray& ray, Caps caps) {
  const double radius = std::fabs(dish.base_radius), height = std::fabs(dish.height);
  if (!std::isfinite(radius + height)) return {};
  if (height <= kFlatDome * radius) return intersect(core::Cylinder{dish.base_radius, 0.0f}, ray, {caps.bottom, true});
  return intersect_dome(ray, radius, height, height, false, caps);
}

core::Mesh tessellate(const core::SphericalDish& dish, const Tessellation& config, Caps caps) {
  constexpr double kHalfTurn = std::numbers::pi;
  const double base = std::fabs(dish.base_radius), height = std::fabs(dish.height);
  if (!std::isfinite(base + height)) return {};
  if (height == 0.0) return tessellate(core::Cylinder{dish.base_radius, 0.0f}, config, {caps.bottom, true});
  const double radius = 0.5 * (base * (base / height) + height), opening = 2.0 * std::atan2(height, base);
  const int columns = segment_count(config, height > base ? radius : base, 2.0 * kHalfTurn);
  const int rows = segment_count(config, radius, opening);
  const std::vector<dvec2> around = arc_points(columns, 2.0 * kHalfTurn);

  MeshBuilder builder;
  builder.add_grid(rows, columns, [&](int row, int column) {
    // From the rim up, by the angle from the pole; the rim's own row is exact, and z keeps its precision on flat
    // dishes.
    const double angle = opening * (rows - row) / rows, across = std::sin(angle), half = std::sin(0.5 * angle);
    const dvec3 normal(across * around[column], std::cos(angle));
    if (row == 0) return Vertex{dvec3(base * around[column], 0.0), normal};
    return Vertex{dvec3(radius * across * around[column], height - 2.0 * radius * half * half), normal};
  });
  if (caps.bottom) builder.add_disc(around, base, 0.0, -1.0);
  return builder.finish();
}

}  // namespace sightline::gpuprims
