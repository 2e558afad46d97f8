// Draws items that contribute too little to the picture as one square each.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/sample_test.h"
#include "sightline/engine/plan.h"
#include "sightline/render/internal/point_splats.h"

namespace sightline::engine {

/// Mean area that an item shows over all directions, square metres: of a convex solid a quarter of its surface (A.
/// Cauchy, 1832). That of tori and meshes is too large, as they are not convex. Slanted ends of snouts count as
/// straight, scaling by different factors as scaling by their mean. Infinity where the placement is singular, so that
/// the bounding box limits it.
float mean_projected_area(const core::Snapshot& snapshot, core::Slot slot);

/// Whether an item is among the `share` (0 … 1) of all items that are kept. The same for an item at all times, and a
/// larger share keeps what a smaller one keeps.
bool in_share(core::ItemId item, float share);

/// Costs nothing before the first draw(). From then on four bytes per slot, and what PointSplats costs.
class SmallItems {
 public:
  struct Rule {
    ContributionWay way;  // kPoints or kStochastic
    float threshold;      // pixels
  };
  /// Draws the slots of `visible` without a bit in `large` beside what the target holds of the same view. An item's
  /// area in the picture is mean_projected_area(), at most that of its bounding box from there. With kStochastic
  /// squares have `threshold` pixels and a share area / threshold of the items is drawn.
  /// `distances`: RenderTarget::read_distances() of what the target holds, or of a part of that; empty: not known.
  core::Expected<void> draw(const gl::Context& context, const core::View& view, const core::Snapshot& snapshot,
                            const core::VisibleSet& visible, culling::SlotBits large, const Rule& rule,
                            std::span<const float> distances, const gpuscene::GpuScene& scene,
                            const render::RenderTarget& target);
  /// Number of squares of the last draw(). With one sample per pixel, those that cover no pixel centre or are hidden do
  /// not count.
  std::size_t drawn() const { return splats_.size(); }

  /// Follows an edit of the snapshot: Drawing::update().
  void update(const core::Snapshot& snapshot, std::span<const core::Slot> touched);
  /// Forgets the areas: another order of the items.
  void reset() { areas_.clear(); }
  std::size_t memory_bytes() const { return points_ ? points_->memory_bytes() : 0; }  ///< of the GPU

 private:
  void grow(const core::Snapshot& snapshot);

  std::vector<float> areas_;  // by slot; empty before the first draw
  std::vector<render::PointSplat> splats_;
  std::optional<render::PointSplats> points_;
};

}  // namespace sightline::engine
