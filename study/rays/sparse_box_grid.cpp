#include "sightline/study/rays/sparse_box_grid.h"

#include <utility>

#include "sightline/study/rays/kd_tree.h"
#include "sightline/study/rays/uniform_grid.h"

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

/// Calls visit(cell number) for each cell of the box; ends with false where that is false.
template <class Visit>
bool all_cells(const GridLines& lines, const SparseBoxGrid::Box& box, const Visit& visit) {
  Cell c;
  for (c[2] = box.low[2]; c[2] < box.high[2]; ++c[2])
    for (c[1] = box.low[1]; c[1] < box.high[1]; ++c[1])
      for (c[0] = box.low[0]; c[0] < box.high[0]; ++c[0])
        if (!visit(lines.index(c))) return false;
  return true;
}

GridLines lines_for(std::size_t boxes, const Aabb& bounds, double cells_per_box) {
  const core::dvec3 size = core::dvec3(bounds.max) - core::dvec3(bounds.min);
  const double cells = cells_per_box * std::max(1.0, double(boxes));
  return {bounds, near_cubes(bounds, std::cbrt(size.x * size.y * size.z / cells), cells)};
}

/// Grows the boxes of build_sbg_by_growth().
class Grower {
 public:
  Grower(SparseBoxGrid& result, const UniformGrid& cells, std::size_t triangles)
      : result_(result), cells_(cells), seen_by_(triangles, core::kNone) {
    result_.lines = cells.lines;
    result_.box_of_cell.assign(cells.lines.count(), core::kNone);
  }

  void run() {
    for (const bool empty : {true, false}) {
      Cell c;
      for (c[2] = 0; c[2] < result_.lines.cells[2]; ++c[2])
        for (c[1] = 0; c[1] < result_.lines.cells[1]; ++c[1])
          for (c[0] = 0; c[0] < result_.lines.cells[0]; ++c[0]) {
            const std::size_t cell = result_.lines.index(c);
            if (result_.box_of_cell[cell] == core::kNone && (in(cell).empty() == empty)) grow(c);
          }
    }
  }

 private:
  using Box = SparseBoxGrid::Box;

  std::span<const std::uint32_t> in(std::size_t cell) const {
    return {cells_.triangles.data() + cells_.begins[cell], cells_.begins[cell + 1] - cells_.begins[cell]};
  }

  void grow(const Cell& start) {
    Box box{};
    for (std::size_t a = 0; a < 3; ++a) box.low[a] = std::uint16_t(start[a]), box.high[a] = std::uint16_t(start[a] + 1);
    box.first = std::uint32_t(result_.triangles.size());
    index_ = std::uint32_t(result_.boxes.size());
    take(box, box);
    for (bool grew = true; grew;) {
      grew = false;
      for (std::size_t face = 0; face < 6; ++face) {
        const std::size_t a = face % 3;
        Box layer = box, larger = box;
        if (face < 3) {
          if (box.low[a] == 0) continue;
          layer.high[a] = box.low[a];
          layer.low[a] = larger.low[a] = std::uint16_t(box.low[a] - 1);
        } else {
          if (box.high[a] == result_.lines.cells[a]) continue;
          layer.low[a] = box.high[a];
          layer.high[a] = larger.high[a] = std::uint16_t(box.high[a] + 1);
        }
        if (!worth_taking(layer, box, larger)) continue;
        take(layer, larger);
        box.low = larger.low, box.high = larger.high, box.count = larger.count;
        grew = true;
      }
    }
    result_.boxes.push_back(box);
  }

  /// Names the layer's cells, and adds their triangles to the growing box's.
  void take(const Box& layer, Box& box) {
    all_cells(result_.lines, layer, [&](std::size_t cell) {
      result_.box_of_cell[cell] = index_;
      for (const std::uint32_t t : in(cell))
        if (std::exchange(seen_by_[t], index_) != index_) result_.triangles.push_back(t);
      return true;
    });
    box.count = std::uint32_t(result_.triangles.size()) - box.first;
  }

  bool worth_taking(const Box& layer, const Box& box, const Box& larger) {
    const bool empty = box.count == 0;
    double apart = cost(box, box.count);
    const Box one{{0, 0, 0}, {1, 1, 1}, 0, 0};
    std::size_t most = 0;  // triangles of the layer; some may be the box's, too
    const bool free = all_cells(result_.lines, layer, [&](std::size_t cell) {
      apart += cost(one, in(cell).size());
      for (const std::uint32_t t : in(cell)) most += seen_by_[t] != index_;
      return result_.box_of_cell[cell] == core::kNone && in(cell).empty() == empty;
    });
    return free && (empty || cost(larger, box.count + most) < apart);
  }

  /// With the costs of the kd-tree's builder.
  double cost(const Box& box, std::size_t triangles) const {
    core::vec3 d;
    for (int a = 0; a < 3; ++a)
      d[a] = float(box.high[std::size_t(a)] - box.low[std::size_t(a)]) * result_.lines.cell[a];
    const KdConfig costs;
    return double(d.x * d.y + d.y * d.z + d.z * d.x) *
           double(costs.traversal_cost + costs.intersection_cost * float(triangles));
  }

  SparseBoxGrid& result_;
  const UniformGrid& cells_;
  std::vector<std::uint32_t> seen_by_;  // by triangle: the last box that took it
  std::uint32_t index_ = 0;             // of the growing box
};

}  // namespace

SparseBoxGrid build_sbg_from_kd_tree(std::span<const Aabb> boxes, const Aabb& bounds, double cells_per_box) {
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
    all_cells(grid.lines, box, [&](std::size_t cell) {
      grid.box_of_cell[cell] = std::uint32_t(grid.boxes.size());
      return true;
    });
    grid.boxes.push_back(box);
  }
  grid.boxes.shrink_to_fit();
  grid.triangles = std::move(tree.triangles);
  return grid;
}

SparseBoxGrid build_sbg_by_growth(std::span<const Aabb> boxes, const Aabb& bounds, double cells_per_box) {
  const GridLines lines = lines_for(boxes.size(), bounds, cells_per_box);
  const UniformGrid cells = build_grid_per_object(boxes, bounds, lines.cells);
  SparseBoxGrid grid;
  Grower(grid, cells, boxes.size()).run();
  grid.boxes.shrink_to_fit();
  grid.triangles.shrink_to_fit();
  return grid;
}

}  // namespace sightline::study::rays
