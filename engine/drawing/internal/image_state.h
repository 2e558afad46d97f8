// State of one image of an engine, kept from frame to frame. Internal to engine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "sightline/core/view.h"
#include "sightline/culling/occlusion/internal/budget_passes.h"
#include "sightline/culling/occlusion/internal/occlusion_passes.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/engine/drawing/internal/draw_choice.h"
#include "sightline/engine/drawing/internal/frame.h"
#include "sightline/engine/drawing/internal/moving_resolution.h"
#include "sightline/engine/drawing/internal/traced_image.h"
#include "sightline/render/internal/render_target.h"

namespace sightline::engine {

/// An engine that shows several views in turn has one state for each, so that what it learns of one view is not lost to
/// the next: Engine::use_image().
struct ImageState {
  render::RenderTarget target;
  bool unchanged = false;  // the last frame drew nothing, because the image was complete

  std::vector<std::uint64_t> was_large;  // contribution's hysteresis: a bit per slot, of the last frame
  culling::OcclusionPasses passes;
  ClusterPasses clusters;
  culling::DepthPyramid pyramid;
  bool pyramid_valid = false;  // the pyramid is never nearer than the image's depth in the present frame
  std::vector<float> distances;
  MeshCounts meshes, meshes_over;  // of the items in the image; of those drawn over it

  // Used with EngineConfig::losses.budget_ms alone.
  culling::BudgetPasses budget;
  std::optional<core::View> budget_view;        // view of the image that the target holds, complete or not
  std::int64_t unmeasured = 0;                  // items that were left out unmeasured because the view moves
  double coarsened = 0.0;                       // pixels within which the budget draws meshes; 0: LossConfig::lod_error
  bool refines = false;                         // the view has stayed, and the image was begun anew with all candidates
  std::optional<render::RenderTarget> refined;  // complete part of the image, where the image itself has more in it
  bool beside = false;                          // `refined` holds that, and the image a copy
  bool shaded = true;                           // Looks::depth_shading: of complete images alone
  double overhead_ms = 0.0;                     // of the last frame, beside drawing its items: grows with the image
  DrawCounts budget_counts;                     // of the last frame
  MovingResolution resolution;
  std::array<std::optional<render::RenderTarget>, MovingResolution::kSteps.size()> smaller;  // from step 1 on
  bool whole = false;          // the moving image has all pixels, and `refined` a copy if it is drawn over
  std::size_t shown_step = 0;  // of `resolution`: 0, or the moving image lies in `smaller`, and enlarged in `target`
  std::optional<TracedImage> traced;  // made with the first one

  /// Whether `target` shows a moving image that is to stay until the one of the view at rest is complete.
  bool shows_moving() const { return shown_step > 0 || shows_traced(); }
  bool shows_traced() const { return traced && traced->shown; }
  std::size_t memory_bytes() const {
    std::size_t bytes = target.memory_bytes() + (refined ? refined->memory_bytes() : 0);
    bytes += traced ? traced->memory_bytes() : 0;
    for (const auto& one : smaller) bytes += one ? one->memory_bytes() : 0;
    return bytes;
  }
  /// After `target` got another size.
  void resized() {
    refined.reset();
    smaller = {};
    traced.reset();
    shown_step = 0;
  }
  /// Tells that the next frame shows something else, though its view may be that of the last one.
  void changed() {
    budget_view.reset();
    if (traced) traced->forget();
  }
  /// Drops all state that is kept by slot. Call it when the items get another order.
  void forget_slots() {
    was_large.clear();
    clusters.reset();
    budget.reset();
    changed();
  }
};

}  // namespace sightline::engine
