// A camera flight for any model, for benchmarks, reports and first looks.
#pragma once

#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/api.h"
#include "sightline/core/camera_path.h"

namespace sightline::core {
class ItemBounds;
struct FittedBounds;
}  // namespace sightline::core

namespace sightline::engine {

/// A flight for any model, from its bounds and item centres alone: overview from several sides, dive-ins to dense
/// places, a walkthrough along the longest horizontal axis at eye height, fast turns, and back to the overview.
/// Deterministic; works for empty and flat bounds. `places` are points worth visiting (item centres, say); it may be
/// empty.
SIGHTLINE_API core::CameraPath make_tour(const core::AabbD& bounds, const std::vector<core::dvec3>& places,
                                         double duration = 60.0);
/// Overload for a snapshot's items without their outliers. `fitted` is what items.fitted_bounds() returned. The places
/// are the centres of at most about 8,000 items.
SIGHTLINE_API core::CameraPath make_tour(const core::ItemBounds& items, const core::FittedBounds& fitted,
                                         double duration = 60.0);

}  // namespace sightline::engine
