// Draws the opaque items of a frame by the strategy that suits it. Internal to engine.
#pragma once

#include "sightline/engine/drawing/internal/draw_strategy.h"
#include "sightline/engine/drawing/internal/occlusion_switch.h"

namespace sightline::engine {

/// A budget has its own strategy. Otherwise small items are left out first, if that is asked for. Where testing
/// occlusion pays, the rest is drawn after an occlusion prepass or in several passes, and elsewhere at once.
class OpaqueItems : public DrawStrategy {
 public:
  core::Expected<DrawCounts> draw(DrawContext& context, const DrawInput& input) override;
  std::size_t memory_bytes() const { return contribution_culling_.memory_bytes(); }  ///< of the GPU

 private:
  OcclusionMode occlusion_mode(const DrawContext& context, const Culled& candidates, std::int64_t count);
  DrawStrategy& tested_strategy(const DrawInput& input);
  core::Expected<DrawCounts> draw_timed(DrawContext& context, const DrawInput& input, DrawStrategy& strategy);
  core::Expected<DrawCounts> draw_and_measure(DrawContext& context, const DrawInput& input);

  ContributionCulling contribution_culling_;
  DrawAtOnce at_once_;
  DrawInPasses in_passes_;
  OcclusionPrepass prepass_;
  DrawInBudget in_budget_{contribution_culling_};
  OcclusionTrial occlusion_trial_;
  OcclusionTrial::Frame trial_ = OcclusionTrial::Frame::kSwitch;  // of the frame
  OcclusionSwitch occlusion_switch_;
  core::Slot measured_part_ = 0;  // of the frame that measured last
  core::VisibleSet sampled_;
};

}  // namespace sightline::engine
