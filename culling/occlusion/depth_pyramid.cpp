#include "sightline/culling/occlusion/depth_pyramid.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "sightline/culling/occlusion/internal/kernels.h"

namespace sightline::culling {
namespace {

constexpr int kCoarsest = 3;    // blocks along each axis of the last level
constexpr int kBandLevels = 5;  // levels whose blocks lie within a band
static_assert(DepthPyramid::kBandRows == 1 << kBandLevels);

}  // namespace

std::vector<DepthPyramid::Level> DepthPyramid::levels_of(int width, int height) {
  assert(width > 0 && height > 0);
  std::vector<Level> levels{{width, height, 0}};
  while (levels.back().width > kCoarsest || levels.back().height > kCoarsest) {
    const Level finer = levels.back();
    levels.push_back({(finer.width + 1) / 2, (finer.height + 1) / 2, std::int32_t(finer.end())});
  }
  return levels;
}

void DepthPyramid::resize(int width, int height) {
  if (this->width() == width && this->height() == height) return;
  levels_ = levels_of(width, height);
  assert(levels_.size() <= widths_.size());
  for (std::size_t i = 0; i < levels_.size(); ++i) widths_[i] = levels_[i].width, firsts_[i] = levels_[i].first;
  texels_.resize(levels_.back().end() + kLanes);
}

void DepthPyramid::clear(int width, int height) {
  resize(width, height);
  std::fill(texels_.begin(), texels_.end(), std::numeric_limits<float>::infinity());
}

void DepthPyramid::build(std::span<const float> distances, int width, int height) {
  assert(distances.size() == std::size_t(width) * std::size_t(height));
  const std::span<float> pixels = begin(width, height);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    pixels[i] = std::isnan(distances[i]) ? std::numeric_limits<float>::infinity() : distances[i];
  finish();
}

std::span<float> DepthPyramid::begin(int width, int height) {
  resize(width, height);
  return std::span(texels_).first(levels_[0].end());
}

void DepthPyramid::finish() {
  for (int band = 0; band < band_count(); ++band) finish_band(band);
  finish_above();
}

/// Finishes the band of all levels whose blocks are no higher than a band.
void DepthPyramid::finish_band(int band) {
  for (int level = 1; level <= kBandLevels; ++level)
    finish_rows(level, band * (kBandRows >> level), (band + 1) * (kBandRows >> level));
}

void DepthPyramid::finish_above() {
  for (int level = kBandLevels + 1; level < level_count(); ++level)
    finish_rows(level, 0, levels_[std::size_t(level)].height);
}

/// Rows first … end - 1, of those that there are, from the next finer level.
void DepthPyramid::finish_rows(int level, int first, int end) {
  if (level >= level_count()) return;
  const Level &fine = levels_[std::size_t(level - 1)], &coarse = levels_[std::size_t(level)];
  for (int y = first; y < std::min(end, int(coarse.height)); ++y) {
    const float *low = row(level - 1, 2 * y), *high = 2 * y + 1 < fine.height ? low + fine.width : low;
    occlusion_kernels().coarser_row(low, high, fine.width,
                                    texels_.data() + coarse.first + std::size_t(y) * std::size_t(coarse.width));
  }
}

bool DepthPyramid::all_nearer(int x0, int y0, int x1, int y1, float distance) const {
  assert(0 <= x0 && x0 <= x1 && x1 < width() && 0 <= y0 && y0 <= y1 && y1 < height());
  // The finest level at which the pixels lie in 9 x 9 blocks at most.
  const unsigned span = unsigned(std::max(x1 - x0, y1 - y0));
  const std::size_t level = std::min(levels_.size() - 1, std::size_t(std::max(3, int(std::bit_width(span))) - 3));
  const int left = x0 >> level, bottom = y0 >> level;
  return occlusion_kernels().all_less(row(int(level), bottom) + left, levels_[level].width, (x1 >> level) - left + 1,
                                      (y1 >> level) - bottom + 1, distance);
}

}  // namespace sightline::culling
