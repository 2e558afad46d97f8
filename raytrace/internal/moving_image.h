// The image of a moving camera, by rays: as many pixels are traced as the time allows, and all others show points that
// earlier images have found. Internal to raytrace and engine.
//
// Traced first are blocks of pixels without a point (PointImage), or with points between nearer ones, then those with
// the oldest points. Sky without a surface nearby counts as an eighth of its age until it is 32 to 63 images old. Where
// many blocks are empty, each gets some points before any is traced whole. Where these and those around find the sky
// alone, it is assumed between them, too.
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
#include "sightline/raytrace/internal/lit.h"
#include "sightline/raytrace/internal/point_image.h"

namespace sightline::raytrace {

/// Costs what PointImage does.
class MovingImage {
 public:
  /// Pixels by what they show: a point that a ray of this view has found; one of an earlier view; that of a neighbour.
  struct Counts {
    std::int64_t traced = 0, kept = 0, filled = 0;
  };

  /// Makes the image of a view. What the scene's items are and look like has not changed since the calls before, unless
  /// forget() was called; parts may come and go. Ends a fraction of a millisecond after the deadline
  /// (core::now_seconds()), but for what grows with the pixels alone. Called again with the same view it goes on; the
  /// image is complete once nothing is kept or filled. Fails as core::image_ray() does.
  core::Expected<Counts> draw(const ImageRequest& request, core::ThreadPool& threads, double deadline);
  /// Begins with an image of a view that is there: what follows it shows its points until rays have met others.
  void begin(const core::View& view, int width, int height, const PointImage::Pixels& image,
             core::ThreadPool& threads) {
    points_.take(width, height, view, image, threads);
    view_ = view;
  }
  /// Whether it is the image of this view.
  bool shows(const core::View& view) const { return view_ && core::same_image(*view_, view); }
  /// Forgets all points. Call it when the scene or its looks have changed.
  void forget() { view_.reset(); }

  /// As PointImage has it.
  template <class Doubts>
  void doubt(const Doubts& doubts) {
    if (view_) points_.doubt(doubts);
  }

  const PointImage& points() const { return points_; }

 private:
  struct Shot;

  void find_urgency(core::ThreadPool& threads);
  void assume_sky(const Shot& shot, std::span<const std::uint32_t> blocks, core::ThreadPool& threads);
  void order_blocks();
  void trace_most_urgent(const Shot& shot, core::ThreadPool& threads, double deadline);
  std::int64_t trace(const Shot& shot, std::span<std::uint32_t> blocks, std::uint32_t places, core::ThreadPool& threads,
                     double deadline, double& rate);
  std::int64_t trace_block(const Shot& shot, std::uint32_t block, std::uint32_t places);
  void shoot(const Shot& shot, const PixelRange& block, std::span<const std::uint32_t> pixels);
  void show(const Shot& shot, const core::Ray& ray, const SceneRays::PartHit& found, std::uint32_t pixel);

  std::optional<core::View> view_;  // of the image; none: its points are forgotten
  PointImage points_;
  std::vector<std::uint32_t> urgency_, order_;   // of each block, by the ages of its points; blocks, most urgent first
  std::vector<std::uint8_t> surfaces_;           // whether a block shows any
  double whole_rate_ = 0.0, sparse_rate_ = 0.0;  // rays a second of whole blocks and of others; 0: not measured
  double finish_seconds_ = 0.0;                  // what followed the rays of the last image
};

}  // namespace sightline::raytrace
