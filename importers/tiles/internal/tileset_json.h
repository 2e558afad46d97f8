// Internal to the writer of 3D Tiles: tileset.json, and where its tiles lie.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/importers/tiles/internal/tile_tree.h"

namespace sightline::importers {

/// Where a tile lies, in the world. All numbers are on one grid, on which doubles add and halve them exactly.
struct TilePlace {
  core::AabbD box;     ///< holds its items and those below it, after rounding to floats
  core::dvec3 centre;  ///< that its content is relative to
  double error = 0.0;  ///< that tileset.json tells: the tile's own and rounding
};

/// By tile. Errors only grow towards the root. `tolerance`: that of primitives in leaves, metres.
std::vector<TilePlace> place_tiles(const TileTree& tree, std::span<const TileItem> items, double tolerance);

/// How tileset.json begins, by which the writer knows its own.
inline constexpr std::string_view kTilesetBegin =
    "{\"asset\":{\"version\":\"1.1\",\"extras\":{\"generator\":\"Sightline\"";

struct TilesetFacts {
  double tolerance = 0.0;    ///< of primitives in leaves, metres
  double whole_error = 0.0;  ///< where nothing is drawn
  bool turned = false;       ///< content has z up
};

/// `contents`: the URI of each tile's file; empty: it has none.
std::string tileset_json(const TileTree& tree, std::span<const TilePlace> places, std::span<const std::string> contents,
                         const TilesetFacts& facts);

}  // namespace sightline::importers
