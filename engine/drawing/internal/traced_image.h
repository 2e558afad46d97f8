// Moving images by rays, on their way into the image of an engine. Internal to engine.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/engine/drawing/internal/frame.h"
#include "sightline/render/internal/render_target.h"

namespace sightline::raytrace {
class MovingImage;
}

namespace sightline::engine {

struct DrawContext;

/// One for each image that moves: raytrace::MovingImage, and lines, which rays do not see.
class TracedImage {
 public:
  bool shown = false;  // the image shows it

  /// Makes the image of a frame that has a tracer, within the budget, and shows it. It has no items of `over`, which
  /// will be drawn over it, or others that the tracer's snapshot has not.
  core::Expected<DrawCounts> draw(DrawContext& context, const Frame& frame, const core::VisibleSet& visible,
                                  culling::SlotBits over);
  /// Begins with an image that is drawn and complete, unless it is that of the view already.
  void begin(DrawContext& context, const core::View& view, const render::RenderTarget& drawn);
  /// Shows it once more, before something is drawn over it again.
  core::Expected<void> show(DrawContext& context, const Frame& frame, const core::VisibleSet& visible);
  /// Whether it shows nothing but what rays of its view have found.
  bool complete() const { return complete_; }
  /// The items that it shows, a bit per slot.
  std::vector<std::uint64_t> shown_slots(const core::Snapshot& snapshot) const;
  void forget();
  std::size_t memory_bytes() const { return single_ ? single_->memory_bytes() : 0; }  ///< of the GPU
  std::size_t points_bytes() const;                                                   ///< of main memory

 private:
  std::shared_ptr<raytrace::MovingImage> image_;  // null before there is one; builds without rays do not know its type
  std::optional<render::RenderTarget> single_;    // with one sample a pixel, where the image has more
  core::VisibleSet lines_, others_;
  bool complete_ = false;
  double show_seconds_ = 0.0;  // what showing took last
};

}  // namespace sightline::engine
