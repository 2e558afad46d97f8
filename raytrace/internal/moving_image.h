// The image of a moving camera, by rays: as many pixels are traced as the time allows, and all others show points that
// earlier images have found. Internal to raytrace and engine.
//
// Traced first are blocks of pixels without a point (PointImage), or with points between nearer ones, then those with
// the oldest points.
//
// Promise: a traced pixel shows what Tracer::nearest() hits through its middle, lit as renderers light it
// (render/shaders/shading.glsl). Any other pixel shows a point of a surface, within half a pixel of its middle if it is
// kept; something nearer may have come before it, for as many images as the pixel waits. Lines are not shown.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sightline/core/thread_pool.h"
#include "sightline/core/view.h"
#include "sightline/gpuprims/surroundings.h"
#include "sightline/raytrace/internal/point_image.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::raytrace {

/// Costs what PointImage does.
class MovingImage {
 public:
  struct Looks {
    gpuprims::Lighting lighting = gpuprims::Lighting::kHeadLight;
    core::dvec3 sun{0.0, 0.0, 1.0};  ///< as gpuprims::distant_lights() has it
    gpuprims::Background background = {};
  };
  /// Pixels by what they show: a point that a ray of this view has found; one of an earlier view; that of a neighbour.
  struct Counts {
    std::int64_t traced = 0, kept = 0, filled = 0;
  };

  /// Makes the image of a view, of what the tracer's snapshot holds: that of the calls before, unless forget() was
  /// called. `without`: as RayFilter has it. Ends a fraction of a millisecond after the deadline (core::now_seconds()),
  /// but for what grows with the pixels alone. Called again with the same view it goes on; the image is complete once
  /// nothing is kept or filled. Fails as core::image_ray() does.
  core::Expected<Counts> draw(const Tracer& tracer, const core::View& view, int width, int height,
                              std::span<const std::uint64_t> without, const Looks& looks, core::ThreadPool& threads,
                              double deadline);
  /// Forgets all points. Call it when the scene or its looks have changed.
  void forget() { view_.reset(); }

  const PointImage& points() const { return points_; }

 private:
  struct Shot;

  void order_blocks(core::ThreadPool& threads);
  void trace_most_urgent(const Shot& shot, core::ThreadPool& threads, double deadline);
  std::int64_t trace(const Shot& shot, std::span<std::uint32_t> blocks, std::uint32_t places, core::ThreadPool& threads,
                     double deadline, double& rate);
  std::int64_t trace_block(const Shot& shot, std::uint32_t block, std::uint32_t places);
  void shoot(const Shot& shot, std::span<const std::uint32_t> pixels);
  void pass_dithered(const Shot& shot, const core::Ray& ray, std::uint32_t pixel, Hit& hit) const;
  void show(const Shot& shot, const core::Ray& ray, const Hit& hit, std::uint32_t pixel);

  std::optional<core::View> view_;  // of the image; none: its points are forgotten
  PointImage points_;
  std::vector<std::uint32_t> urgency_, order_;   // of each block, by the ages of its points; blocks, most urgent first
  double whole_rate_ = 0.0, sparse_rate_ = 0.0;  // rays a second of whole blocks and of others; 0: not measured
  double finish_seconds_ = 0.0;                  // what followed the rays of the last image
};

}  // namespace sightline::raytrace
