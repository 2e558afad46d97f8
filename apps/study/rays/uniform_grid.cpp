#include "sightline/apps/study/rays/uniform_grid.h"

#include <limits>
#include <utility>

namespace sightline::study::rays {
namespace {

using core::Aabb;
using core::vec3;

struct CellRange {
  Cell first, last;
  std::size_t count() const {
    std::size_t n = 1;
    for (std::size_t a = 0; a < 3; ++a) n *= std::size_t(last[a] - first[a] + 1);
    return n;
  }
};

CellRange range_of(const GridLines& lines, const Aabb& box) {
  CellRange range;
  for (int a = 0; a < 3; ++a) {
    range.first[std::size_t(a)] = lines.cell_of(a, box.min[a]);
    range.last[std::size_t(a)] = lines.cell_of(a, box.max[a]);
  }
  return range;
}

template <class Visit>
void for_each_cell(const CellRange& range, const Visit& visit) {
  Cell c;
  for (c[2] = range.first[2]; c[2] <= range.last[2]; ++c[2])
    for (c[1] = range.first[1]; c[1] <= range.last[1]; ++c[1])
      for (c[0] = range.first[0]; c[0] <= range.last[0]; ++c[0]) visit(c);
}

/// Turns counts into begins, in place; the last entry becomes the sum.
void sum_up(std::vector<std::uint32_t>& counts) {
  std::uint32_t sum = 0;
  for (std::uint32_t& c : counts) sum += std::exchange(c, sum);
}

}  // namespace

Cell grid_resolution(const Aabb& bounds, std::size_t boxes, double factor) {
  const vec3 size = bounds.max - bounds.min;
  const double number = std::max(1.0, double(boxes));
  return near_cubes(bounds, double(std::min({size.x, size.y, size.z})) / (factor * std::cbrt(number)), 27.0 * number);
}

Cell automatic_resolution(std::span<const Aabb> boxes, const Aabb& bounds) {
  constexpr double kIntersectionCost = 1.5;  // of a cell: 1, as for the kd-tree
  Cell best;
  double best_cost = std::numeric_limits<double>::infinity();
  for (const double factor : {1.0, 1.5, 2.0, 2.5, 3.0}) {
    const GridLines lines(bounds, grid_resolution(bounds, boxes.size(), factor));
    std::size_t references = 0;
    for (const Aabb& box : boxes) references += range_of(lines, box).count();
    const vec3 d = lines.cell;
    const double area = double(d.x * d.y + d.y * d.z + d.z * d.x);
    const double cost = area * (double(lines.count()) + kIntersectionCost * double(references));
    if (cost < best_cost) best_cost = cost, best = lines.cells;
  }
  return best;
}

UniformGrid build_grid(std::span<const Aabb> boxes, const Aabb& bounds, const Cell& cells) {
  UniformGrid grid;
  grid.lines = GridLines(bounds, cells);
  grid.begins.assign(grid.lines.count() + 1, 0);
  for (const Aabb& box : boxes)
    for_each_cell(range_of(grid.lines, box), [&](const Cell& c) { ++grid.begins[grid.lines.index(c)]; });
  sum_up(grid.begins);
  grid.triangles.resize(grid.begins.back());
  std::vector<std::uint32_t> ends(grid.begins.begin(), grid.begins.end() - 1);
  for (std::uint32_t i = 0; i < boxes.size(); ++i)
    for_each_cell(range_of(grid.lines, boxes[i]),
                  [&](const Cell& c) { grid.triangles[ends[grid.lines.index(c)]++] = i; });
  return grid;
}

}  // namespace sightline::study::rays
