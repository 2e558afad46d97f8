// One step of simplification, by meshoptimizer's edge collapses. Internal to lod.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/conventions.h"

namespace sightline::lod {

/// Fewer triangles with some of the same vertices: about `target`, or as few as collapses allow. Vertices that are
/// `locked` keep their place; others at open borders move along these. Says nothing about the error. `corners` are
/// indices of `positions`, three a triangle. No two positions are equal.
std::vector<std::uint32_t> simplify(std::span<const core::vec3> positions, std::span<const std::uint32_t> corners,
                                    std::span<const std::uint8_t> locked, std::size_t target);

}  // namespace sightline::lod
