// The depth pyramid: for each block of pixels, how far what is drawn there is at most. The occlusion test
// (occlusion_test.h) looks at blocks instead of pixels.
//
// After N. Greene, M. Kass, G. Miller, "Hierarchical Z-buffer visibility", 1993.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/culling/occlusion/detail/screen_view.h"

namespace sightline::culling {

/// Farthest distances of blocks of 1, 2 x 2, 4 x 4, … pixels, of any image size. Blocks at the right and upper edge
/// hold fewer pixels.
class SIGHTLINE_API DepthPyramid {
 public:
  /// `distances`: along the viewing direction from the eye, in metres, row by row from the bottom up; infinity where
  /// nothing is. A NaN counts as infinity. width * height of them, both positive. Keeps its memory.
  void build(std::span<const float> distances, int width, int height);

  /// As build() from distances that all are infinity: nothing is drawn yet.
  void clear(int width, int height);

  /// In place: distances for the caller to write, as build() takes them, but without NaN. Then finish(). Or, on several
  /// threads, write a band of kBandRows rows and call finish_band(), for all of them; then finish_above() once.
  std::span<float> begin(int width, int height);
  void finish();
  static constexpr int kBandRows = 32;
  int band_count() const { return (height() + kBandRows - 1) / kBandRows; }
  void finish_band(int band);
  void finish_above();

  int width() const { return levels_.empty() ? 0 : levels_[0].width; }
  int height() const { return levels_.empty() ? 0 : levels_[0].height; }
  /// True only if the pixels x0 … x1, y0 … y1, at least one and all within the image, hold less than `distance`. It
  /// may be false because of a pixel beside them: at most 9 x 9 blocks that contain them are looked at,
  /// single pixels where they are no more.
  bool all_nearer(int x0, int y0, int x1, int y1, float distance) const;

  /// Blocks of a level, and the number of those of the levels before.
  struct Level {
    std::int32_t width, height, first;
    std::size_t end() const { return std::size_t(first) + std::size_t(width) * std::size_t(height); }
  };
  /// All levels of a pyramid of so many pixels, both positive: down to 3 x 3 blocks or fewer.
  static std::vector<Level> levels_of(int width, int height);
  int level_count() const { return int(levels_.size()); }
  /// Farthest distances of a row of blocks of 2^level x 2^level pixels. Sixteen floats from any of them on may be read.
  const float* row(int level, int y) const {
    const Level& l = levels_[std::size_t(level)];
    return texels_.data() + l.first + std::size_t(y) * std::size_t(l.width);
  }
  PyramidBlocks blocks() const { return {texels_.data(), widths_.data(), firsts_.data(), level_count()}; }
  std::size_t memory_bytes() const { return texels_.capacity() * sizeof(float); }

 private:
  void resize(int width, int height);
  void finish_rows(int level, int first, int end);

  std::vector<Level> levels_;
  std::array<std::int32_t, PyramidBlocks::kMostLevels> widths_{}, firsts_{};  // of these
  std::vector<float> texels_;
};

}  // namespace sightline::culling
