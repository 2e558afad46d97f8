// Synthetic process plants: input for demos, tests and benchmarks where no real model may be used.
#pragma once

#include <cstdint>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"

namespace sightline::importers {

struct PlantOptions {
  std::uint64_t items = 100'000;  ///< exactly so many items come out; 1 000 … 10 000 000
  std::uint64_t seed = 1;
};

/// Appends a plant below the scene's root: pipe racks and process areas of pipe runs, valves, vessels, tanks, pumps,
/// steel, platforms, stairs and handrails, in groups SITE / ZONE / PIPE or EQUIPMENT or STRUCTURE / BRANCH, one
/// material per group.
///
/// 65 % of the items are cylinders, 20 % circular torus slices, 5 % snouts and 10 % boxes, dishes and the rest (to the
/// item, up to rounding). Radii run from 2 mm to 4 m, roughly evenly over their logarithm. The plant stands on z = 0,
/// centred in x and y, Z up, within 400 x 100 x 60 m. Below 100 000 items its area shrinks in proportion; above, it
/// gets denser. As in RVM files, parameters are millimetres, and placements scale them to metres and have
/// single-precision coordinates, so that a plant survives being written and read. Pipe ends meet within 0.1 mm.
///
/// The scene's content depends on `config` alone, on every platform with IEEE arithmetic. Nothing is committed. Fails
/// when `items` is out of range; the scene is then unchanged.
SIGHTLINE_API core::Expected<void> generate_plant(const PlantOptions& config, core::Scene& scene);

}  // namespace sightline::importers
