// Uniform grids in compact form (A. Lagae, P. Dutré, "Compact, Fast and Robust Grids for Ray Tracing", 2008: one list
// of all triangles, sorted by cell), and the 3D-DDA of J. Amanatides and A. Woo (1987).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/apps/study/rays/grid_lines.h"
#include "sightline/apps/study/rays/query.h"

namespace sightline::study::rays {

struct UniformGrid {
  GridLines lines;
  std::vector<std::uint32_t> begins;  ///< of each cell in `triangles`, and their end
  std::vector<std::uint32_t> triangles;

  std::size_t bytes() const { return (begins.size() + triangles.size()) * sizeof(std::uint32_t); }
};

/// Cells as near to cubes as can be, `factor` times the cube root of the number of boxes along the shortest axis
/// (the dissertations use 1 to 3), but not more than 27 cells a box in all: a flat scene would have any number.
Cell grid_resolution(const core::Aabb& bounds, std::size_t boxes, double factor);

/// The factor between 1 and 3 whose grid costs a ray least by the surface-area heuristic: all cells are equal,
/// so the cost is the number of cells and references times the area of a cell.
Cell automatic_resolution(std::span<const core::Aabb> boxes, const core::Aabb& bounds);

/// Builds by walking the cells of each box: a pass that counts, and one that fills.
UniformGrid build_grid(std::span<const core::Aabb> boxes, const core::Aabb& bounds, const Cell& cells);

/// Parameters at planes are computed from the plane's number: sums of steps would drift.
struct GridDda {
  template <class Q>
  static void walk(const UniformGrid& grid, const UnitRay& ray, Q& query) {
    const GridLines& lines = grid.lines;
    Cell at, step;
    core::vec3 next;
    const auto plane_ahead = [&](int a) { return ray.at(a, lines.line(a, at[std::size_t(a)] + !ray.negative(a))); };
    for (int a = 0; a < 3; ++a) {
      at[std::size_t(a)] = lines.cell_of(a, ray.origin[a]);
      step[std::size_t(a)] = ray.negative(a) ? -1 : 1;
      next[a] = plane_ahead(a);
    }
    for (;;) {
      query.visit();
      const int x_or_y = next.x <= next.y ? 0 : 1;
      const int axis = next[x_or_y] <= next.z ? x_or_y : 2;
      const std::size_t cell = lines.index(at);
      const std::span<const std::uint32_t> triangles(grid.triangles.data() + grid.begins[cell],
                                                     grid.begins[cell + 1] - grid.begins[cell]);
      if (query.test(triangles, next[axis]) || next[axis] >= ray.exit) return;
      std::int32_t& i = at[std::size_t(axis)];
      i += step[std::size_t(axis)];
      if (i < 0 || i >= lines.cells[std::size_t(axis)]) return;
      next[axis] = plane_ahead(axis);
    }
  }
};

}  // namespace sightline::study::rays
