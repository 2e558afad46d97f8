// An image by rays alone, whole: what renderers draw, for machines without OpenGL. Internal to raytrace and engine.
//
// Promise: a pixel shows what Tracer::nearest() hits through each of its samples, lit as renderers light it
// (render/shaders/shading.glsl), and the lines that pass it. A rasteriser's image differs where it rounds corners (on
// silhouettes), where surfaces lie at the same depth, and by a pixel along lines.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/core/thread_pool.h"
#include "sightline/raytrace/internal/lit.h"

namespace sightline::raytrace {

/// Lines of one pixel, which rays do not hit.
struct TracedLines {
  const core::Snapshot* snapshot = nullptr;
  std::span<const core::Slot> slots = {};
};

/// Keeps its memory from image to image: 12 bytes a pixel, and 8 more with several samples.
class StillImage {
 public:
  /// Row by row from the bottom up: colours with red in the lowest byte and alpha in the highest, reversed depths (0:
  /// nothing) and ids + 1. Of several samples per pixel the mean of the colours, and the first one's depth and id.
  /// Valid until the next draw().
  struct Pixels {
    std::span<std::uint32_t> colours;
    std::span<const float> depths;
    std::span<const std::uint32_t> ids;
  };

  /// Fails as core::image_ray() does.
  core::Expected<void> draw(const ImageRequest& request, const TracedLines& lines, int samples,
                            core::ThreadPool& threads);
  Pixels pixels() { return {colours_, depths_, ids_}; }
  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t memory_bytes() const;

 private:
  struct Shot;
  struct Sums {
    std::uint16_t r, g, b, a;
  };

  void trace(const Shot& shot, core::ThreadPool& threads);
  void trace_tile(const Shot& shot, std::uint32_t tile);
  void show(const Shot& shot, const core::Ray& ray, const SceneRays::PartHit& found, std::uint32_t pixel);
  void draw_line(const Shot& shot, const core::Snapshot& snapshot, core::Slot slot);
  void add(int sample, int samples);

  int width_ = 0, height_ = 0;
  std::vector<std::uint32_t> colours_, ids_, first_ids_;
  std::vector<float> depths_, first_depths_;
  std::vector<Sums> sums_;
};

}  // namespace sightline::raytrace
