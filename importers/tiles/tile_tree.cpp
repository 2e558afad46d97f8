#include "sightline/importers/tiles/internal/tile_tree.h"

#include <algorithm>
#include <bit>

#include "sightline/core/block_order.h"

namespace sightline::importers {
namespace {

constexpr int kHalvings = 3;  // from a tile to its children, of which there are at most eight

struct Range {
  std::uint32_t first, count;
};

/// The costs before each place of the order, and all of them.
std::vector<std::uint64_t> sums_of(std::span<const std::uint32_t> order, std::span<const std::uint64_t> costs) {
  std::vector<std::uint64_t> sums{0};
  for (const std::uint32_t item : order) sums.push_back(sums.back() + costs[item]);
  return sums;
}

}  // namespace

TileTree build_tile_tree(std::span<const TileItem> items, std::span<const std::uint64_t> costs, std::uint64_t most) {
  core::AabbD all;
  for (const TileItem& item : items) all.grow(item.box);
  std::vector<core::Aabb> boxes;
  for (const TileItem& item : items) boxes.push_back(core::round_outwards(item.box, all.centre()));
  TileTree tree;
  tree.order = core::block_order(boxes, {.smallest_block = 1});
  const std::vector<std::uint64_t> sums = sums_of(tree.order, costs);
  const auto is_large = [&](const Range& range) {
    return range.count > 1 && sums[range.first + range.count] - sums[range.first] > most;
  };
  tree.tiles.push_back({0, std::uint32_t(items.size())});
  std::vector<Range> parts, halves;
  for (std::size_t i = 0; i < tree.tiles.size(); ++i) {
    parts.assign(1, {tree.tiles[i].first, tree.tiles[i].count});
    if (!is_large(parts[0])) continue;
    for (int halving = 0; halving < kHalvings; ++halving) {
      halves.clear();
      for (const Range& part : parts) {
        // Where the order itself divides them: each part lies together.
        const std::uint32_t left = is_large(part) ? std::bit_ceil(part.count) / 2 : part.count;
        halves.push_back({part.first, left});
        if (left < part.count) halves.push_back({part.first + left, part.count - left});
      }
      parts.swap(halves);
    }
    tree.tiles[i].first_child = std::uint32_t(tree.tiles.size());
    tree.tiles[i].child_count = std::uint32_t(parts.size());
    for (const Range& part : parts) tree.tiles.push_back({part.first, part.count});
  }
  return tree;
}

bool choose_errors(TileTree& tree, std::span<const TileItem> items, double least, std::uint64_t most,
                   const std::function<std::uint64_t(const TileItem&, double)>& cost,
                   const std::function<bool(double)>& proceed) {
  for (std::size_t i = tree.tiles.size(); i-- > 0;) {
    if (!proceed(1.0 - double(i + 1) / double(tree.tiles.size()))) return false;
    Tile& tile = tree.tiles[i];
    if (tile.leaf()) continue;
    tile.error = least;
    for (std::uint32_t c = 0; c < tile.child_count; ++c)
      tile.error = std::max(tile.error, tree.tiles[tile.first_child + c].error);
    const auto fits = [&] {
      std::uint64_t sum = 0;
      for (const std::uint32_t item : tree.items_of(tile)) {
        if (items[item].size > tile.error) sum += cost(items[item], tile.error);
        if (sum > most) return false;
      }
      return true;
    };
    while (!fits()) tile.error *= 2.0;
  }
  return true;
}

}  // namespace sightline::importers
