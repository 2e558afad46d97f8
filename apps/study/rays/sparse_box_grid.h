// Sparse Box Grids (A. L. dos Santos, "Estruturas de Aceleração para Ray Tracing em Tempo Real", 2011, 3.6): disjoint
// boxes, and a uniform grid whose cells name the box that they lie in. Any point finds its box in constant time.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/apps/study/rays/grid_lines.h"
#include "sightline/apps/study/rays/query.h"

namespace sightline::study::rays {

struct SparseBoxGrid {
  /// Cells low … high - 1 of each axis.
  struct Box {
    std::array<std::uint16_t, 3> low, high;
    std::uint32_t first, count;
  };
  GridLines lines;
  std::vector<std::uint32_t> box_of_cell;
  std::vector<Box> boxes;
  std::vector<std::uint32_t> triangles;

  std::size_t bytes() const {
    return boxes.size() * sizeof(Box) + (box_of_cell.size() + triangles.size()) * sizeof(std::uint32_t);
  }
};

/// The boxes are the leaves of a kd-tree whose splits lie on the grid's lines. `cells_per_box`: of the grid, roughly,
/// to each of `boxes`; more allow splits closer to the best.
SparseBoxGrid build_sbg(std::span<const core::Aabb> boxes, const core::Aabb& bounds, double cells_per_box = 8.0);

/// Goes from box to box. A face lies on a line of the grid, so the next cell's number across it is exact. On the other
/// axes it stays within the box that the ray leaves, and never goes back.
struct SbgWalk {
  template <class Q>
  static void walk(const SparseBoxGrid& grid, const UnitRay& ray, Q& query) {
    const GridLines& lines = grid.lines;
    Cell cell;
    for (int a = 0; a < 3; ++a) cell[std::size_t(a)] = lines.cell_of(a, ray.origin[a]);
    for (;;) {
      query.visit();
      const SparseBoxGrid::Box& box = grid.boxes[grid.box_of_cell[lines.index(cell)]];
      float exit = 0.0f;
      int axis = -1;
      for (int a = 0; a < 3; ++a) {
        const float t = ray.at(a, lines.line(a, ray.negative(a) ? box.low[std::size_t(a)] : box.high[std::size_t(a)]));
        if (axis < 0 || t < exit) exit = t, axis = a;
      }
      if (query.test({grid.triangles.data() + box.first, box.count}, exit) || exit >= ray.exit) return;
      for (int a = 0; a < 3; ++a) {
        const std::size_t i = std::size_t(a);
        if (a == axis) {
          cell[i] = ray.negative(a) ? box.low[i] - 1 : box.high[i];
        } else {
          const std::int32_t here = lines.cell_of(a, ray.point(a, exit));
          cell[i] = ray.negative(a) ? std::clamp(here, std::int32_t(box.low[i]), cell[i])
                                    : std::clamp(here, cell[i], box.high[i] - 1);
        }
      }
      if (cell[std::size_t(axis)] < 0 || cell[std::size_t(axis)] >= lines.cells[std::size_t(axis)]) return;
    }
  }
};

}  // namespace sightline::study::rays
