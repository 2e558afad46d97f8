// The models that the dissertation of 2009 measures hybrid culling with, as scenes that can be drawn.
#pragma once

#include "sightline/bench/models/platforms.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"

namespace sightline::bench {

/// A generated plant of the platform's primitives (table 3.1, which its GPU culling ran on; no meshes), to the item at
/// `scale` 1. What the generator has too much of is given as another kind in the same place and of the same size: a
/// torus slice in a straight one's place is a pipe bent a little. Fails where the plant does.
core::Expected<void> make_platform_scene(const Platform& platform, double scale, core::Scene& scene);

/// The aircraft of models/aircraft.h, each box of it an instance of one of a few shared prisms that fill it.
void make_aircraft_scene(double scale, core::Scene& scene);

}  // namespace sightline::bench
