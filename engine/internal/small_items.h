// Draws items that contribute too little to the picture as one square each.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/contribution.h"
#include "sightline/engine/plan.h"
#include "sightline/render/internal/point_splats.h"

namespace sightline::engine {

/// Whether an item is among the `share` (0 … 1) of all items that are kept. The same for an item at all times, and a
/// larger share keeps what a smaller one keeps.
bool in_share(core::ItemId item, float share);

/// Costs nothing before the first draw(). From then on what PointSplats costs, and memory for the squares of a frame.
class SmallItems {
 public:
  struct Rule {
    ContributionWay way;  // kPoints or kStochastic
    float threshold;      // pixels
  };
  /// Draws the slots of `visible` without a bit in `large` beside what the target holds of the same view. `test`
  /// measures the squares. With kStochastic they have `threshold` pixels and a share area / threshold of the items is
  /// drawn. With one sample per pixel, squares that cover no pixel centre, or that the picture or other squares hide,
  /// are left out.
  /// `distances`: RenderTarget::read_distances() of what the target holds, or of a part of that; empty: not known.
  core::Expected<void> draw(const gl::Context& context, const core::View& view, const core::Snapshot& snapshot,
                            const culling::ContributionTest& test, const core::VisibleSet& visible,
                            culling::SlotBits large, const Rule& rule, std::span<const float> distances,
                            const gpuscene::GpuScene& scene, const render::RenderTarget& target);
  /// Number of squares of the last draw().
  std::size_t drawn() const { return splats_.size(); }

  std::size_t memory_bytes() const { return points_ ? points_->memory_bytes() : 0; }  ///< of the GPU

 private:
  using Square = culling::ContributionTest::Square;
  void leave_out_hidden(const core::View& view, const core::Snapshot& snapshot, float fixed_side,
                        std::span<const float> distances, const render::RenderTarget& target);

  std::vector<Square> squares_;
  std::vector<float> nearest_;  // of each pixel, row by row from the bottom up
  std::vector<render::PointSplat> splats_;
  std::optional<render::PointSplats> points_;
};

}  // namespace sightline::engine
