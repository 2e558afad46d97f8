// Common form of the sphere and both dishes: a quadric of revolution, cut at its base. Internal to gpuprims.
#pragma once

#include "sightline/gpuprims/internal/ray.h"

namespace sightline::gpuprims {

/// A dome flatter than this times its radius is a two-sided disc.
inline constexpr double kFlatDome = 1e-18;

/// Crossings with x^2 + y^2 <= (1 - g) (radius^2 + bulge^2 g) with g = z / height, which is
///   half an ellipsoid above z = 0  with bulge = radius,
///   the cap of a sphere            with bulge = height (and no centre far below, from which a flat cap would lose all
///                                  precision).
/// Needs radius >= 0, bulge > 0 and height > kFlatDome * radius, all finite. `whole`: not cut at the base.
Hits intersect_dome(const Ray& ray, double radius, double bulge, double height, bool whole, Caps caps);

}  // namespace sightline::gpuprims
