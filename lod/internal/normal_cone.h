// The cone about the normals of triangles. Internal to lod.
#pragma once

#include <cstdint>
#include <span>

#include "sightline/lod/mesh_levels.h"

namespace sightline::lod {

/// A narrow cone, as NormalCone promises. `corners` are indices of `positions`, which are finite, three a triangle, and
/// at most 3 * kClusterTriangles.
NormalCone cone_of(std::span<const core::vec3> positions, std::span<const std::uint32_t> corners);

}  // namespace sightline::lod
