// Which triangles of a mesh never show their back to an eye outside. Internal to gpuscene.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/conventions.h"

namespace sightline::gpuscene {

/// Moves the triangles of solid shells to the front, all others behind them, both in their order; returns how many
/// indices the solid ones have. All indices must be below positions.size().
///
/// A shell is what hangs together by common positions. It counts as solid when it is closed, every edge (as a pair of
/// positions) being run as often forth as back, and star-shaped: seen from some point c none of its triangles is
/// clockwise. A ray from c then only ever leaves the shell, so the winding number of a point, which is the number of
/// crossings behind it on that ray, is nowhere negative; and a ray from where it is 0 first crosses the shell inwards,
/// through a front face. That proves nothing for bent shells, which no point sees all of: they are never solid.
///
/// Closedness compares sums of hashes and errs once in 2^64. c is looked for by relaxation: S. Agmon, "The relaxation
/// method for linear inequalities", 1954. Costs about 0.1 us for each triangle.
std::uint32_t solid_shells_first(std::span<const core::vec3> positions, std::span<std::uint32_t> indices);

}  // namespace sightline::gpuscene
