// Puts clusters below groups. Internal to lod.
#pragma once

#include <cstdint>
#include <span>

#include "sightline/lod/mesh_levels.h"

namespace sightline::lod {

/// Makes a group of clusters that go into none yet. Its box, error and angle are the least that the clusters and what
/// they were made by allow. Returns its number.
std::uint32_t join_clusters(MeshLevels& levels, std::span<const std::uint32_t> members);

/// Lists what goes into no group as roots. Where these are many, groups of infinite error hold neighbours together.
void list_roots(MeshLevels& levels);

}  // namespace sightline::lod
