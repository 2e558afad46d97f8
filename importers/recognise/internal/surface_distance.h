// Internal to the recognition of primitives: distances of points from the surfaces of primitives.
#pragma once

#include <functional>

#include "sightline/core/primitive.h"

namespace sightline::importers::recognition {

/// Distance of a point, in local units, from the primitive's surface, ends included. Exact near the surface up to
/// second order; away from it never more than the distance where the surface has edges, and a bound of the right size
/// elsewhere. Lines are infinitely far.
using SurfaceDistance = std::function<double(const core::dvec3&)>;
SurfaceDistance surface_distance(const core::Primitive& primitive);

}  // namespace sightline::importers::recognition
