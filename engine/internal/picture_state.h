// What one picture of an engine remembers from frame to frame. Internal to engine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "sightline/core/view.h"
#include "sightline/culling/occlusion.h"
#include "sightline/engine/internal/budget_passes.h"
#include "sightline/engine/internal/occlusion_passes.h"
#include "sightline/render/internal/render_target.h"

namespace sightline::engine {

/// An engine that shows several views in turn has one for each, so that what it learns of one view is not lost to the
/// next: Engine::use_picture().
struct PictureState {
  render::RenderTarget target;
  bool kept = false;      // the last frame drew nothing: the picture was complete
  bool composed = false;  // the framebuffer that it goes into has got it

  std::vector<std::uint64_t> was_large;  // a bit per slot, of the last frame
  OcclusionPasses passes;
  culling::DepthPyramid pyramid;
  std::vector<float> distances;

  // With a budget.
  BudgetPasses budget;
  std::optional<core::View> budget_view;  // whose picture the target holds, complete or not
  std::int64_t overlooked = 0;            // items that were not even measured while the view moves
  bool refines = false;                   // the view has stayed, and the picture was begun anew with all candidates
  std::optional<render::RenderTarget> refined;  // beside the picture, which then has squares, too

  std::size_t memory_bytes() const { return target.memory_bytes() + (refined ? refined->memory_bytes() : 0); }
  /// The next frame shows something else, though its view may be that of the last one.
  void changed() { budget_view.reset(); }
  /// Forgets what it knows by slots: there is another order of the items.
  void forget_slots() {
    was_large.clear();
    budget.reset();
    changed();
  }
};

}  // namespace sightline::engine
