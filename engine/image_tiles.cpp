#include "sightline/engine/image_tiles.h"

#include <algorithm>
#include <string>

namespace sightline::engine {
namespace {

constexpr int kPattern = 4;  // pixels of the dither's pattern; it also keeps quads of 2 x 2 as they are

int rounded_up(int value) {
  return (value + kPattern - 1) / kPattern * kPattern;
}

/// From the left, or from the bottom.
struct Interval {
  int origin;      // of the tile
  int begin, end;  // that is taken
};

struct Axis {
  int side;  // of each tile
  std::vector<Interval> intervals;
};

Axis split(int length, int largest_side, int margin) {
  if (length <= largest_side) return {length, {{0, 0, length}}};
  const int largest_step = (largest_side - 2 * margin - (kPattern - 1)) / kPattern * kPattern;
  const int inner = length - 2 * margin, count = (inner + largest_step - 1) / largest_step;
  const int step = rounded_up((inner + count - 1) / count);
  Axis axis{step + 2 * margin + (length - step - 2 * margin) % kPattern, {}};
  for (int i = 0, taken = 0; i < count; ++i) {
    const bool last = i + 1 == count;
    const int origin = last ? length - axis.side : i * step, end = last ? length : origin + axis.side - margin;
    axis.intervals.push_back({origin, taken, end});
    taken = end;
  }
  return axis;
}

}  // namespace

core::Expected<ImageTiles> image_tiles(int width, int height, int largest_side, int more_margin) {
  if (width < 1 || height < 1 || more_margin < 0)
    return core::fail("image tiles: width and height must be above 0, and margins not below");
  const int margin = rounded_up(kTileMargin + more_margin);
  if (largest_side < kLeastTileSide + 2 * margin)
    return core::fail("image tiles: a side of " + std::to_string(largest_side) + " pixels is too small, expected " +
                      std::to_string(kLeastTileSide + 2 * margin) + " or more");
  const Axis x = split(width, largest_side, margin), y = split(height, largest_side, margin);
  ImageTiles made{x.side, y.side, {}};
  for (auto row = y.intervals.rbegin(); row != y.intervals.rend(); ++row)
    for (const Interval& column : x.intervals)
      made.tiles.push_back({{width, height, double(column.origin), double(height - row->origin - y.side)},
                            column.begin,
                            height - row->end,
                            column.end,
                            height - row->begin});
  return made;
}

}  // namespace sightline::engine
