// Sort-last: several processes draw a part of a scene each, and their images meet pixel by pixel, by depth. After
// Molnar, Cox, Ellsworth and Fuchs, "A Sorting Classification of Parallel Rendering" (IEEE Computer Graphics and
// Applications 14(4), 1994).
#pragma once

#include <cstdint>
#include <span>

namespace sightline::apps {

/// What a part shows in a pixel.
struct Fragment {
  float depth = 0.0f;                ///< as the GPU has it, reversed: 1 at the near plane, 0 where nothing is
  std::uint32_t order = 0xffffffff;  ///< of the item: in an image of all, the lower of two at equal depth shows
  std::uint32_t id = 0;              ///< item + 1; 0 is background
  std::uint32_t colour = 0;          ///< R lowest
};
static_assert(sizeof(Fragment) == 16);

/// Whether `a` hides `b`. Total on depth and order, so that the nearest of any number of fragments does not depend on
/// how they are grouped.
constexpr bool hides(const Fragment& a, const Fragment& b) {
  return a.depth > b.depth || (a.depth == b.depth && a.order < b.order);
}

/// Leaves in `into` what shows of both, pixel by pixel. The images have one size.
void compose(std::span<const Fragment> more, std::span<Fragment> into);

}  // namespace sightline::apps
