// One cylinder against many rays at once: the vector form of cylinder.h for shooting whole images or beams.
#pragma once

#include <cstddef>
#include <span>

#include "sightline/core/primitive.h"
#include "sightline/gpuprims/internal/ray.h"

namespace sightline::bench {

/// Rays as a structure of arrays, `count` values each, borrowed: origin + t * direction in the cylinder's local units.
/// Lengths of directions between 1e-70 and 1e70 (any, in cylinder.h), origins up to 1e100.
struct RayArrays {
  const double* origin[3];
  const double* direction[3];
  std::size_t count;
};

/// t[i] = the first crossing of ray i at t >= t_min[i], infinity for none (also where a value is not finite). The same
/// crossings as intersect() in cylinder.h finds, from the same formulas, to a few roundings; open ends drop theirs.
/// `t` and `t_min` hold rays.count values. Instructions as core/internal/instruction_set.h says, the answer bit for bit
/// the same for all of them.
void first_crossings(const core::Cylinder& cylinder, const RayArrays& rays, std::span<const double> t_min,
                     gpuprims::Caps caps, std::span<double> t);

}  // namespace sightline::bench
