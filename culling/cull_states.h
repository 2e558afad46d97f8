// What culling makes of every item in one view, for those who look at it from outside: a viewer that draws boxes around
// what was kept and what was not, a test, a report. Computed with the culler's own tests (frustum_test.h) on its own
// hierarchy, but slot by slot: meant for one view that is looked at for a while, not for every frame.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"
#include "sightline/culling/frustum/hierarchy.h"
#include "sightline/culling/occlusion/sample_test.h"

namespace sightline::culling {

enum class CullState : std::uint8_t {
  kInside,        ///< drawn; its box lies wholly in the view volume
  kIntersecting,  ///< drawn; its box crosses the view volume's border
  kOutside,       ///< its box lies outside the view volume, or its layers are not the view's
  kOccluded,      ///< in the view volume, and hidden by others
  kTooSmall,      ///< in the view volume, and covers no sample, or too few pixels to be drawn
};
inline constexpr int kCullStateCount = 5;
constexpr std::string_view name_of(CullState state) {
  constexpr std::string_view kNames[] = {"inside", "intersecting", "outside", "occluded", "too_small"};
  return kNames[std::size_t(state)];
}

/// A node of the hierarchy or a single item.
struct CullBox {
  core::Aabb box;  ///< relative to ItemBounds::origin
  CullState state;
  std::uint32_t items;  ///< of that state in it; above 0
};

struct CullStates {
  std::vector<CullState> of_slot;                     ///< of a vacant slot: kOutside
  std::array<std::int64_t, kCullStateCount> items{};  ///< by state; vacant slots do not count
  /// Inside and outside: the nodes at which a walk of the hierarchy stops. Below leaves that cross the border, each
  /// item. Occluded and too small: the largest nodes that hold nothing else, otherwise each item. So each item is in
  /// one box of its state, and those of an inside node that are left out are in other boxes besides.
  std::vector<CullBox> boxes;
};

/// `hierarchy`: over `bounds`. `small`, `occluded`: slots that the tests after the view volume's have left out, with
/// precedence of the first; bits of items outside the view volume are ignored.
///
/// Promise: not outside are exactly the items that every culler returns for the view. An item is inside only if it is
/// for certain: within rounding of the border it intersects. Sections belong to the view volume. Time is linear in the
/// number of slots.
SIGHTLINE_API CullStates cull_states(const core::View& view, const core::ItemBounds& bounds, const Hierarchy& hierarchy,
                                     SlotBits small = {}, SlotBits occluded = {});

}  // namespace sightline::culling
