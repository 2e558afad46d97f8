// Images larger than what is drawn at once: the tiles that Engine::frame_tile() draws of them.
#pragma once

#include <array>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"

namespace sightline::engine {

/// A tile of an image, of the size that the engine draws in.
struct ImageTile {
  int width = 0, height = 0;  ///< of the whole image, pixels
  double x = 0.0, y = 0.0;    ///< of the tile's upper left corner in it
  friend bool operator==(const ImageTile&, const ImageTile&) = default;
};

/// A tile, and the rectangle of the whole image that is taken from it: x0 ≤ x < x1, y0 ≤ y < y1, rows from the top.
struct CroppedTile {
  ImageTile tile;
  int x0, y0, x1, y1;
  friend bool operator==(const CroppedTile&, const CroppedTile&) = default;
};

/// All tiles have one size. Their rectangles cover the image, each pixel once.
struct ImageTiles {
  int width = 0, height = 0;       ///< of each tile
  std::vector<CroppedTile> tiles;  ///< rows from the top, each from left to right; those of a row have equal y0 and y1
};

/// What looks at neighbouring pixels (depth shading, outlines) is right that far inside a tile.
inline constexpr int kTileMargin = 8;
inline constexpr int kLeastTileSide = 64;

/// Tiles of at most `largest_side` pixels a side, about equally large, that join without seams. They overlap by margins
/// of kTileMargin and `more_margin` pixels, but none reaches over the image's borders, and their lower left corners
/// lie at multiples of four pixels, as the pattern of dithered transparency wants. With
/// EngineConfig::losses.contribution_mode that draws splats, `more_margin` should be a splat's side.
///
/// Fails unless width and height are above 0, and largest_side at least kLeastTileSide and twice the margins more.
SIGHTLINE_API core::Expected<ImageTiles> image_tiles(int width, int height, int largest_side, int more_margin = 0);

}  // namespace sightline::engine
