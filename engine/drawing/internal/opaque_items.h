// Draws the opaque items of a frame by the strategy that suits it. Internal to engine.
#pragma once

#include "sightline/culling/hybrid/internal/occlusion_switch.h"
#include "sightline/engine/drawing/internal/draw_strategy.h"

namespace sightline::engine {

/// Small items are left out first, if that is asked for. Where testing occlusion pays, the rest is drawn after an
/// occlusion prepass or in several passes, and elsewhere at once. Within a budget a software rasteriser draws all of a
/// moving image so, with as few pixels as that takes; images at rest, and those of a GPU, have a strategy of their own.
class OpaqueItems {
 public:
  /// `over`: items that will be drawn over the image, of which `visible` has none.
  core::Expected<DrawCounts> draw(DrawContext& context, const Frame& frame, const core::VisibleSet& visible,
                                  culling::SlotBits over = {});
  std::size_t memory_bytes() const { return contribution_culling_.memory_bytes(); }  ///< of the GPU

 private:
  core::Expected<DrawCounts> draw_all(DrawContext& context, const Frame& frame, const core::VisibleSet& visible,
                                      float least_area);
  static DrawCounts keep_whole(ImageState& image);
  core::Expected<DrawCounts> draw_whole(DrawContext& context, const Frame& frame, const core::VisibleSet& visible);
  core::Expected<DrawCounts> draw_smaller(DrawContext& context, const Frame& frame, const core::VisibleSet& visible);
  core::Expected<DrawCounts> draw_traced(DrawContext& context, const Frame& frame, const core::VisibleSet& visible,
                                         culling::SlotBits over);
  core::Expected<DrawCounts> draw_moving(DrawContext& context, const Frame& frame, const core::VisibleSet& visible);
  culling::OcclusionMode occlusion_mode(const DrawContext& context, const Frame& frame,
                                        const core::VisibleSet& candidates);
  core::Expected<void> measure(DrawContext& context, const Frame& frame, const core::VisibleSet& candidates,
                               double tested_ms);

  ContributionCulling contribution_culling_;
  DrawAtOnce at_once_;
  DrawInPasses in_passes_;
  OcclusionPrepass prepass_;
  DrawInBudget in_budget_{contribution_culling_};
  culling::OcclusionTrial occlusion_trial_;
  culling::OcclusionTrial::Frame trial_ = culling::OcclusionTrial::Frame::kSwitch;  // of the frame
  culling::OcclusionSwitch occlusion_switch_;
  core::Slot measured_part_ = 0;  // of the frame that measured last
  core::VisibleSet sampled_;
};

}  // namespace sightline::engine
