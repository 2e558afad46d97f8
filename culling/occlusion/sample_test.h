// The sample test: which boxes can colour an image at all. An image is a finite set of samples, and an item whose
// projection contains none of them colours nothing, wherever it lies in depth. Distant items mostly are of that kind.
//
// Promise: conservative, so an image loses nothing. A box is rejected only when the rectangle around its projection
// contains no sample (internal/screen_boxes.h), or when no ray through one of these samples meets the box (internal/
// ray_spans.h). Both are computed in float and grown by every error of that and by what a rasteriser may move a
// vertex. Boxes that reach behind the eye, and of those with a larger rectangle than 16 x 16 pixels all, are kept. All
// instruction sets give the same answer.
//
// Lines are drawn one pixel wide, by a rule of their own: they colour pixels whose centres they miss. Callers exempt
// them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/fixed_list.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/thread_pool.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/occlusion/detail/ray_spans.h"
#include "sightline/culling/occlusion/detail/screen_view.h"

namespace sightline::culling {

/// Pixels by which any GL's rasteriser may move a vertex: it has four bits of sub-pixel precision or more.
inline constexpr float kCoarsestSnap = 0.08f;
/// The snap of a rasteriser with so many bits (GL_SUBPIXEL_BITS), with what float loses of a place.
inline float rasteriser_snap(int subpixel_bits, int width, int height) {
  return std::ldexp(1.0f, -subpixel_bits) + 0x1p-20f * float(std::max(width, height));
}

inline constexpr std::size_t kMostSamples = 32;  ///< of a pixel

/// Where an image takes its samples.
struct ImageSamples {
  int width = 0, height = 0;  ///< pixels, positive
  core::FixedList<std::array<float, 2>, kMostSamples> offsets{
      {0, 0}};                 ///< of a pixel's samples from its centre, pixels; not empty
  float snap = kCoarsestSnap;  ///< rasteriser_snap()
};

/// A bit per slot, from the lowest bit of the first word on. Slots beyond the last word have none.
using SlotBits = std::span<const std::uint64_t>;
inline bool contains(SlotBits bits, core::Slot slot) {
  return slot / 64 < bits.size() && (bits[slot / 64] >> slot % 64 & 1u) != 0;
}

struct BoxRectangles;

/// Sets the bits of the slots of `set`, which must be there.
SIGHTLINE_API void set_bits(const core::VisibleSet& set, std::vector<std::uint64_t>& bits);
/// The slots whose bit is set, in rising order; and in place of what `slots` held.
SIGHTLINE_API std::vector<core::Slot> slots_of(SlotBits bits);
SIGHTLINE_API void slots_of(SlotBits bits, std::vector<core::Slot>& slots);
/// As many words as a bit for each of so many slots takes.
constexpr std::size_t bit_words(std::size_t slot_count) {
  return slot_count / 64 + 1;
}

class SIGHTLINE_API SampleTest {
 public:
  /// `origin`: of the bounds whose boxes will be tested.
  SampleTest(const core::View& view, const core::dvec3& origin, ImageSamples samples);

  /// Whether a box may cover a sample. Empty boxes cover none.
  bool covers(const core::Aabb& box) const;

  /// Replaces `out` by the slots of `in` whose boxes may cover a sample, or whose bit is set in `exempt`. Vacant slots
  /// are left out. Time linear in the number of slots of `in`, which `threads` share; the result is the same.
  void filter(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& out, SlotBits exempt = {},
              core::ThreadPool* threads = nullptr) const;

 private:
  class Boxes;

  ImageSamples samples_;
  ScreenView view_;
  RaySpans rays_;
  core::FixedList<RayField, kMostSamples> fields_;  // by sample; none where nothing is known of rays
};

}  // namespace sightline::culling
