// Items that the sample and the occlusion test leave out of the image of one view, shown in another view. Internal to
// engine.
#pragma once

#include <optional>

#include "sightline/engine/drawing/internal/draw_strategy.h"

namespace sightline::engine {

/// For frames whose culling view is not the view that they show, with EngineConfig::drawing.culled_colour: the items
/// that the image of the culling view would not show are drawn in that colour. Costs nothing before the first such
/// frame.
class UnseenItems {
 public:
  bool active() const { return split_view_.has_value(); }
  /// Tells that the image of the culling view may be another one.
  void reset() { split_view_.reset(); }
  /// Splits the visible items of the culling view into those that its image shows and the others. Once for all frames
  /// of one culling view: its image is drawn for the distances.
  core::Expected<void> split(DrawContext& context, const Frame& frame, const core::VisibleSet& visible);
  const core::VisibleSet& seen() const { return seen_; }
  /// Draws the others beside what the image holds of the view, which may occlude most of them. Returns their number.
  core::Expected<std::int64_t> draw(DrawContext& context, const Frame& frame);

 private:
  core::Expected<void> make_materials(const DrawContext& context, const core::Snapshot& snapshot);

  std::optional<core::View> split_view_;
  core::VisibleSet seen_, unseen_, drawn_;
  gl::TexelArray materials_;  // one colour for all
  DrawInPasses in_passes_;
};

}  // namespace sightline::engine
