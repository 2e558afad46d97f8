// Fewer of many loose parts, for groups of triangles that edges collapsing would spoil. Internal to lod.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/conventions.h"

namespace sightline::lod {

/// The corners without some parts, each of which lies near one that stays, until at most `target` triangles are left or
/// no part can go. A part is what edges and points hold together; parts with locked points stay. Small ones that lie
/// near another one go first. Empty where none can go, or they are too many to compare. How far that is off, a proof
/// has to say.
std::vector<std::uint32_t> without_loose_parts(std::span<const core::vec3> positions,
                                               std::span<const std::uint32_t> corners,
                                               std::span<const std::uint8_t> locked, std::size_t target);

}  // namespace sightline::lod
