// Internal to the writer of 3D Tiles: which tiles there are, and how far each may be off.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sightline/importers/tiles/internal/tile_items.h"

namespace sightline::importers {

struct Tile {
  std::uint32_t first = 0, count = 0;              ///< in TileTree::order
  std::uint32_t first_child = 0, child_count = 0;  ///< they follow each other; none: a leaf
  double error = 0.0;                              ///< metres; 0 of leaves
  bool leaf() const { return child_count == 0; }
};

struct TileTree {
  std::vector<std::uint32_t> order;  ///< of the items, by place
  std::vector<Tile> tiles;           ///< the root first, children after their parents

  std::span<const std::uint32_t> items_of(const Tile& tile) const {
    return std::span(order).subspan(tile.first, tile.count);
  }
};

/// Divides the items, at least one, until no leaf of several has more than `most` of the sum of `costs`.
TileTree build_tile_tree(std::span<const TileItem> items, std::span<const std::uint64_t> costs, std::uint64_t most);

/// Sets the errors of inner tiles: the least power of two times `least`, not below their children's, by which their
/// items cost at most `most`. `cost`: of an item within an error; items no larger than the error cost nothing. False
/// where `proceed`, which takes the share that is done, stopped it.
bool choose_errors(TileTree& tree, std::span<const TileItem> items, double least, std::uint64_t most,
                   const std::function<std::uint64_t(const TileItem&, double)>& cost,
                   const std::function<bool(double)>& proceed);

}  // namespace sightline::importers
