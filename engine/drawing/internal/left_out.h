// Queries between frames: which visible items an image leaves out. Internal to engine.
#pragma once

#include "sightline/engine/drawing/internal/draw_strategy.h"
#include "sightline/engine/drawing/internal/image_overlays.h"

namespace sightline::engine {

/// The visible items that an image of the view would leave out. Draws that image for its depth, so that the last one is
/// gone. Uses no history: contribution's threshold has no hysteresis.
core::Expected<LeftOut> find_left_out(DrawContext& context, ImageOverlays& overlays, const Frame& frame,
                                      const core::VisibleSet& visible);

/// Error of the last frame by EngineConfig::losses: Engine::loss(). `visible` must be what that frame was drawn from.
core::Expected<LossReport> measure_loss(DrawContext& context, const Frame& frame, const core::VisibleSet& visible);

}  // namespace sightline::engine
