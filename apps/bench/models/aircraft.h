// Made-up airliner of boxes: a scene with the number and the manner of parts of the largest model of E. T. Carlos
// ("Frustum Culling Híbrido Utilizando CPU e GPU", 2009).
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/core/aabb.h"

namespace sightline::bench {

inline constexpr std::size_t kAircraftMeshes = 712823;

/// Exactly `count` boxes of meshes, metres, nose towards +x: fuselage (63 m long, 6.2 m wide) and wings as shells of
/// skin panels, frames, stringers, ribs; systems inside (harness clips, ducts, pipes, brackets); cabin (seats, bins,
/// floor beams); engines with densely packed small parts; fasteners everywhere. Many thin and long boxes, strongly
/// uneven density. Depends on `count` and `seed` alone.
std::vector<core::Aabb> make_aircraft(std::size_t count = kAircraftMeshes, std::uint64_t seed = 1);

}  // namespace sightline::bench
