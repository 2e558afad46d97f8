// Items in a region of space: a rectangle of an image, or what any planes keep. Tests shapes and not only boxes.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"

namespace sightline::culling {

enum class RegionRule : std::uint8_t {
  kCrossing,  ///< any part of the item lies in the region
  kWholly,    ///< all of it does
};

/// The view whose image is this rectangle of another view's image of width x height pixels. In pixels from the upper
/// left corner, in any order; a side below a thousandth of a pixel counts as one. Layers and sections are kept. Fails
/// unless all numbers are finite, and width and height above 0.
SIGHTLINE_API core::Expected<core::View> rectangle_view(const core::View& view, int width, int height, double x0,
                                                        double y0, double x1, double y1);
/// A view without an image, whose volume is what all planes keep; at most core::kMaxSectionPlanes.
SIGHTLINE_API core::View region_view(std::vector<core::Plane> planes, std::uint32_t layers = core::kDefaultLayerMask);

/// Lists those of `candidates`, which a culler found for the view, that lie in its volume by the rule: in rising order
/// of slots. The volume is what the view's planes and its sections keep; where sections unite, what the planes and any
/// of them keep, and to be inside is to be inside one of these parts. What items hide plays no role.
///
/// Promises, up to double rounding of the coordinates:
///   - kWholly: every item reported lies in the volume. None is missing, but for snouts with slanted ends, whose
///     support function is an upper bound.
///   - kCrossing: no item with a part in the volume is missing. Meshes are reported exactly, by their surface: one
///     that the whole volume lies within is not. So are boxes and lines. Other solids are reported unless one of many
///     directions separates them from the volume: the volume's and the box's axes, the products of their edges, and
///     those from its corners and edges to the item's middle. So some may be reported that pass a corner nearby. Tori
///     count with what their sweep encloses.
SIGHTLINE_API std::vector<core::Slot> items_in_region(const core::Snapshot& snapshot, const core::View& view,
                                                      const core::VisibleSet& candidates, RegionRule rule);

}  // namespace sightline::culling
