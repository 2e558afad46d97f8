// Everything that is done to the image of the opaque items: depth shading and edges, then translucent items, ghosts and
// outlines over it. Internal to engine.
#pragma once

#include <functional>
#include <optional>

#include "sightline/engine/drawing/internal/draw_context.h"
#include "sightline/engine/drawing/internal/item_edges.h"
#include "sightline/engine/drawing/internal/translucent.h"
#include "sightline/render/internal/depth_shading_pass.h"
#include "sightline/render/internal/overlays.h"

namespace sightline::engine {

/// Costs nothing in frames without depth shading and edges, and without items to draw over the image.
class ImageOverlays {
 public:
  explicit ImageOverlays(TranslucentSlots translucent) : translucent_(std::move(translucent)) {}

  TranslucentSlots& translucent() { return translucent_; }
  /// Items that are drawn over the image, a bit per slot.
  culling::SlotBits items() const { return translucent_.bits(); }
  /// Whether the CPU finds the visible items, also where the GPU culls.
  bool needs_visible(const DrawContext& context) const {
    return any(context) || (context.renderer && context.config.drawing.looks.edges.any());
  }
  /// Whether any items are drawn over the image. A GPU that culls leaves out translucent ones.
  bool any(const DrawContext& context) const {
    return context.renderer && !(items().empty() && translucent_.outlined().empty());
  }
  /// Whether finish() changes the image of the opaque items.
  bool change_image(const DrawContext& context) const { return context.config.drawing.looks.finish() || any(context); }

  /// Splits a visible set: returns its opaque items, and keeps the others for finish().
  const core::VisibleSet& split(const DrawContext& context, const core::VisibleSet& visible);
  /// Eye depths between which the blended items of a set lie.
  glm::vec2 blend_range(const core::View& view, const core::Snapshot& snapshot, const core::VisibleSet& visible);
  /// Completes the image, and puts it into the frame's external target. `visible`: all visible items, of which split()
  /// was called last. Blended items are weighed by the frame's range of eye depths, or else by their own. Adds to
  /// `counts` the items that it draws.
  core::Expected<void> finish(DrawContext& context, const Frame& frame, const core::VisibleSet& visible,
                              DrawCounts& counts);
  /// Draws an outline of visible items over a framebuffer: Engine::draw_outline(). The image stays.
  core::Expected<void> put_outline(DrawContext& context, const Frame& frame, const core::VisibleSet& items,
                                   const gl::ExternalTarget& over);
  /// Depth shading, and edges of `opaque` items.
  core::Expected<void> draw_looks(DrawContext& context, const Frame& frame, const core::VisibleSet& opaque);
  std::size_t memory_bytes() const {  ///< of the GPU
    return (overlays_ ? overlays_->memory_bytes() : 0) + edges_.memory_bytes();
  }

 private:
  render::Overlays& overlays(const DrawContext& context);
  bool shades(const DrawContext& context, const DrawCounts& counts) const;
  core::Expected<void> draw_over(DrawContext& context, const Frame& frame, const core::VisibleSet& visible,
                                 DrawCounts& counts);
  core::Expected<void> draw_translucent(DrawContext& context, const Frame& frame, DrawCounts& counts);
  core::Expected<void> draw_blended(DrawContext& context, const Frame& frame, const glm::vec2& range);
  core::Expected<void> draw_ghosts(DrawContext& context, const Frame& frame);
  core::Expected<void> draw_outline(DrawContext& context, const Frame& frame, const core::VisibleSet& visible);
  core::Expected<render::PixelBox> draw_outlined(DrawContext& context, const Frame& frame,
                                                 const core::VisibleSet& items);
  const core::VisibleSet& leave_out_invisible(DrawContext& context, const Frame& frame, const core::VisibleSet& items);

  TranslucentSlots translucent_;
  std::optional<render::Overlays> overlays_;                    // created with the first overlay
  std::optional<render::DepthShadingPass> depth_shading_pass_;  // created with the first frame that has depth shading
  ItemEdges edges_;
  core::VisibleSet opaque_, over_, blended_, ghosts_, outlined_, tested_, unused_;  // subsets of the visible items
};

}  // namespace sightline::engine
