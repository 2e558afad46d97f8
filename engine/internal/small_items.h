// Draws items that contribute too little to the picture as one square each.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/culling/contribution.h"
#include "sightline/culling/internal/set_parts.h"
#include "sightline/culling/occlusion.h"
#include "sightline/engine/internal/culled.h"
#include "sightline/render/internal/point_splats.h"

namespace sightline::engine {

/// Whether an item is among the `share` (0 … 1) of all items that are kept. The same for an item at all times, and a
/// larger share keeps what a smaller one keeps.
bool in_share(core::ItemId item, float share);

/// Costs nothing before the first draw(). From then on what PointSplats costs, and memory for the squares of a frame.
class SmallItems {
 public:
  /// What the target holds, or a part of that. Borrowed.
  struct Known {
    std::span<const float> distances = {};              ///< RenderTarget::read_distances(); empty: not known
    const culling::OcclusionTest* occlusion = nullptr;  ///< against these
  };
  /// Draws the visible slots without a bit in `large` beside what the target holds of the same view. `test` measures
  /// the squares. Of those smaller than `least_area`, in pixels, a share area / least_area is drawn, with that area; 0:
  /// all. With one sample per pixel, squares that cover no pixel centre, or that the picture or other squares hide, are
  /// left out.
  core::Expected<void> draw(const gl::Context& context, const Culled& culled, const culling::ContributionTest& test,
                            culling::SlotBits large, float least_area, const Known& known,
                            const gpuscene::GpuScene& scene, const render::RenderTarget& target,
                            culling::CullThreads& threads);
  /// Number of squares of the last draw().
  std::size_t drawn() const { return splats_.size(); }

  std::size_t memory_bytes() const { return points_ ? points_->memory_bytes() : 0; }  ///< of the GPU

 private:
  using Square = culling::ContributionTest::Square;
  void find(const Culled& culled, const culling::ContributionTest& test, culling::SlotBits large, float least_area,
            const Known& known, const render::RenderTarget& target, culling::CullThreads& threads);

  culling::SetParts parts_;
  struct Part {
    std::vector<Square> squares;
    std::vector<render::PointSplat> splats;
  };
  std::vector<Part> of_part_;
  std::vector<float> nearest_;  // of each pixel, row by row from the bottom up
  std::vector<render::PointSplat> splats_;
  std::optional<render::PointSplats> points_;
};

}  // namespace sightline::engine
