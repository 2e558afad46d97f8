// The sample test: which boxes can colour a picture at all. A picture is a finite set of samples, and an item whose
// projection contains none of them colours nothing, wherever it lies in depth. Distant items mostly are of that kind.
//
// Promise: conservative, so a picture loses nothing. A box is rejected only when the rectangle around its projection,
// computed in float and grown by every error of that and by what a rasteriser may move a vertex (internal/
// screen_boxes.h), contains no sample. Boxes that reach behind the eye are kept. All instruction sets give the same
// answer. The rectangle is larger than the projection, so some boxes without a sample are kept.
//
// Lines are drawn one pixel wide, by a rule of their own: they colour pixels whose centres they miss. Callers exempt
// them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/internal/screen_view.h"

namespace sightline::culling {

/// Where a picture takes its samples.
struct PictureSamples {
  int width = 0, height = 0;                          ///< pixels, positive
  std::vector<std::array<float, 2>> offsets{{0, 0}};  ///< of a pixel's samples from its centre, pixels; not empty
};

/// A bit per slot, from the lowest bit of the first word on. Slots beyond the last word have none.
using SlotBits = std::span<const std::uint64_t>;
inline bool contains(SlotBits bits, core::Slot slot) {
  return slot / 64 < bits.size() && (bits[slot / 64] >> slot % 64 & 1u) != 0;
}

class SIGHTLINE_API SampleTest {
 public:
  /// `origin`: of the bounds whose boxes will be tested.
  SampleTest(const core::View& view, const core::dvec3& origin, PictureSamples samples);

  /// Whether a box may cover a sample. Empty boxes cover none.
  bool covers(const core::Aabb& box) const;

  /// Replaces `out` by the slots of `in` whose boxes may cover a sample, or whose bit is set in `exempt`. Vacant slots
  /// are left out. Time linear in the number of slots of `in`.
  void filter(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& out,
              SlotBits exempt = {}) const;

 private:
  ScreenView view() const;

  PictureSamples samples_;
  ScreenView view_;
};

}  // namespace sightline::culling
