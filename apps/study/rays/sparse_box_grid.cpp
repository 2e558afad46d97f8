#include "sightline/apps/study/rays/sparse_box_grid.h"

#include <utility>

#include "sightline/apps/study/rays/kd_tree.h"

namespace sightline::study::rays {
namespace {

using core::Aabb;

SparseBoxGrid::Box cells_of(const GridLines& lines, const Aabb& box) {
  SparseBoxGrid::Box result{};
  for (int a = 0; a < 3; ++a) {
    const auto line_at = [&](float p) { return std::uint16_t(std::lround((p - lines.low[a]) * lines.per_cell[a])); };
    result.low[std::size_t(a)] = line_at(box.min[a]);
    result.high[std::size_t(a)] = line_at(box.max[a]);
  }
  return result;
}

GridLines lines_for(std::size_t boxes, const Aabb& bounds, double cells_per_box) {
  const core::dvec3 size = core::dvec3(bounds.max) - core::dvec3(bounds.min);
  const double cells = cells_per_box * std::max(1.0, double(boxes));
  return {bounds, near_cubes(bounds, std::cbrt(size.x * size.y * size.z / cells), cells)};
}

}  // namespace

SparseBoxGrid build_sbg(std::span<const Aabb> boxes, const Aabb& bounds, double cells_per_box) {
  SparseBoxGrid grid;
  grid.lines = lines_for(boxes.size(), bounds, cells_per_box);
  KdConfig config;
  config.lines = &grid.lines;
  KdTree tree = build_kd_tree(boxes, bounds, config);
  grid.box_of_cell.resize(grid.lines.count());
  const std::vector<Aabb> node_box = node_boxes(tree);
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    const KdNode& node = tree.nodes[i];
    if (!node.is_leaf()) continue;
    SparseBoxGrid::Box box = cells_of(grid.lines, node_box[i]);
    box.first = node.first(), box.count = node.count();
    Cell c;
    for (c[2] = box.low[2]; c[2] < box.high[2]; ++c[2])
      for (c[1] = box.low[1]; c[1] < box.high[1]; ++c[1])
        for (c[0] = box.low[0]; c[0] < box.high[0]; ++c[0])
          grid.box_of_cell[grid.lines.index(c)] = std::uint32_t(grid.boxes.size());
    grid.boxes.push_back(box);
  }
  grid.boxes.shrink_to_fit();
  grid.triangles = std::move(tree.triangles);
  return grid;
}

}  // namespace sightline::study::rays
