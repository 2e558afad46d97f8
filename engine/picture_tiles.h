// Pictures larger than what is drawn at once: the parts that Engine::frame_part() draws of them.
#pragma once

#include <array>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"

namespace sightline::engine {

/// A part of a picture, of the size that the engine draws in.
struct PicturePart {
  int width = 0, height = 0;  ///< of the whole picture, pixels
  double x = 0.0, y = 0.0;    ///< of the part's upper left corner in it
  friend bool operator==(const PicturePart&, const PicturePart&) = default;
};

/// A part, and the rectangle of the whole picture that is taken from it: x0 ≤ x < x1, y0 ≤ y < y1, rows from the top.
struct PictureTile {
  PicturePart part;
  int x0, y0, x1, y1;
  friend bool operator==(const PictureTile&, const PictureTile&) = default;
};

/// All parts have one size. Their rectangles cover the picture, each pixel once.
struct PictureTiles {
  int width = 0, height = 0;       ///< of each part
  std::vector<PictureTile> tiles;  ///< rows from the top, each from left to right; those of a row have equal y0 and y1
};

/// What looks at neighbouring pixels (relief, outlines) is right that far inside a part.
inline constexpr int kTileMargin = 8;
inline constexpr int kLeastTileSide = 64;

/// Parts of at most `largest_side` pixels a side, about equally large, that join without seams. They overlap by margins
/// of kTileMargin and `more_margin` pixels, but none reaches over the picture's borders, and their lower left corners
/// lie at multiples of four pixels, as the pattern of dithered transparency wants. With
/// EngineConfig::losses.contribution_way that draws squares, `more_margin` should be a square's side.
///
/// Fails unless width and height are above 0, and largest_side at least kLeastTileSide and twice the margins more.
SIGHTLINE_API core::Expected<PictureTiles> picture_tiles(int width, int height, int largest_side, int more_margin = 0);

}  // namespace sightline::engine
