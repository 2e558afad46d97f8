// Items below the minimum projected area: left out, or drawn as one splat each. Internal to engine.
#pragma once

#include <optional>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/culling/frustum/internal/set_parts.h"
#include "sightline/culling/occlusion/contribution.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/engine/drawing/internal/draw_context.h"
#include "sightline/render/internal/point_splats.h"

namespace sightline::engine {

/// Whether an item is among the `share` (0 … 1) of all items that are kept. The same for an item at all times, and a
/// larger share keeps what a smaller one keeps.
bool in_share(core::ItemId item, float share);

/// Costs nothing before the first draw(). From then on what PointSplats costs, and memory for the splats of a frame.
class ContributionCulling {
 public:
  /// The subset of the candidates that project to `threshold` pixels or more, with the image's hysteresis; all of them
  /// where it is 0. Valid until the next call.
  const core::VisibleSet& leave_out(DrawContext& context, const Frame& frame, const core::VisibleSet& candidates,
                                    float threshold);

  /// Which items are drawn as splats.
  struct Splats {
    culling::SlotBits large;   ///< those without a bit
    float least_area = 0.0f;   ///< of items smaller than so many pixels, a share area / least_area, with that area
    bool depth_known = false;  ///< the image's distances and depth pyramid are valid
  };
  /// Draws splats beside what the image holds of the same view. With one sample per pixel, splats that cover no pixel
  /// centre, or that the image or other splats occlude, are left out. Returns the number of splats.
  core::Expected<std::int64_t> draw(DrawContext& context, const Frame& frame, const core::VisibleSet& visible,
                                    const Splats& splats);

  std::size_t memory_bytes() const { return points_ ? points_->memory_bytes() : 0; }  ///< of the GPU

 private:
  using Splat = culling::ContributionTest::Splat;
  void find(DrawContext& context, const Frame& frame, const core::VisibleSet& visible, const Splats& wanted);

  core::VisibleSet large_, large_leaves_;
  culling::SetParts parts_;
  struct Part {
    core::VisibleSet open;
    std::vector<Splat> candidates;
    std::vector<render::PointSplat> splats;
  };
  std::vector<Part> of_part_;
  std::vector<float> nearest_;  // distance by pixel, row by row from the bottom up
  std::vector<render::PointSplat> splats_;
  std::optional<render::PointSplats> points_;
};

}  // namespace sightline::engine
