// The models that the dissertation of 2009 uses to measure hybrid culling, as scenes that can be drawn.
#pragma once

#include "sightline/apps/bench/models/platforms.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"

namespace sightline::bench {

/// A generated plant with the platform's primitives (table 3.1, used for its GPU culling; no meshes), exact to the item
/// at `scale` 1. Surplus items of the generator become another kind in the same place and of the same size: a torus
/// slice instead of a straight item is a slightly bent pipe. Fails where the plant does.
core::Expected<void> make_platform_scene(const Platform& platform, double scale, core::Scene& scene);

/// The aircraft of models/aircraft.h. Each of its boxes is an instance of one of a few shared prisms that fill it.
void make_aircraft_scene(double scale, core::Scene& scene);

}  // namespace sightline::bench
