// One step of simplification, by meshoptimizer's edge collapses. Internal to lod.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/conventions.h"

namespace sightline::lod {

/// Fewer triangles with some of the same vertices: `target` or somewhat more, or as few as collapses allow. Positions
/// that several vertices have (at creases) stay together. Vertices that are `locked` keep their place; others at open
/// borders move along these. Says nothing about the error. `corners` are indices of `positions`, three a triangle.
std::vector<std::uint32_t> simplify(std::span<const core::vec3> positions, std::span<const std::uint32_t> corners,
                                    std::span<const std::uint8_t> locked, std::size_t target);

}  // namespace sightline::lod
