// Areas and volumes of items.
#pragma once

#include <optional>
#include <span>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/mesh.h"
#include "sightline/core/scene.h"

namespace sightline::measure {

/// Square and cubic metres.
struct Amounts {
  double area = 0.0;        ///< of the whole surface, ends included; of an open mesh that of one side
  double area_error = 0.0;  ///< the true area is no farther from that
  double volume = 0.0;      ///< of closed items
  double volume_error = 0.0;
  std::size_t open = 0;  ///< items without volume: open meshes (core::enclosure()), and lines
};

/// Measures a primitive itself, not triangles. Exact up to rounding (1e-13 of the amount; areas as exactly as the
/// placement is a similarity), but for areas of eccentric and slanted snouts, of tori that reach beyond their axis and
/// of primitives that are scaled unequally, and volumes of slanted snouts. These are sums of values at 1,024 to 262,144
/// places (Gauss and trapezoid rules, with twice as many in either direction until nothing changes), whose last change
/// is the error, mostly 1e-12 of the amount. Of a snout whose slanted ends cross or have no closed contour it is
/// infinite. Fails when a parameter or the placement is not finite.
SIGHTLINE_API core::Expected<Amounts> amounts(const core::Primitive& primitive, const core::Affine& world_from_item);
/// Measures a mesh's triangles. Fails on a mesh that fails validate(), and when the placement is not finite.
SIGHTLINE_API core::Expected<Amounts> amounts(const core::Mesh& mesh, const core::Affine& world_from_item);
/// The sum over items. What lies within several of them counts as often.
SIGHTLINE_API core::Expected<Amounts> amounts(const core::Scene& scene, std::span<const core::ItemId> items);

}  // namespace sightline::measure
