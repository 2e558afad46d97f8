// Draws the edges of a frame's items over its image. Internal to engine.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sightline/engine/drawing/internal/draw_context.h"
#include "sightline/engine/internal/edge_lists.h"
#include "sightline/render/internal/edge_pass.h"

namespace sightline::engine {

/// Costs nothing before the first draw(). From then on what EdgeLists and render::EdgePass cost.
class ItemEdges {
 public:
  /// Draws the edges of `items`, all of the image of `frame`, as Edges has it.
  core::Expected<void> draw(DrawContext& context, const Frame& frame, const core::VisibleSet& items);
  std::size_t memory_bytes() const { return pass_ ? pass_->memory_bytes() : 0; }  ///< of the GPU

 private:
  EdgeLists lists_;
  std::optional<render::EdgePass> pass_;
  std::uint32_t generation_ = 0;  // of the segments that pass_ has
  std::vector<core::Slot> slots_;
};

}  // namespace sightline::engine
