// One cylinder against many rays at once: the vector form of cylinder.h, for whole images or beams.
#pragma once

#include <cstddef>
#include <span>

#include "sightline/core/primitive.h"
#include "sightline/gpuprims/internal/ray.h"

namespace sightline::bench {

/// Rays as a structure of arrays, `count` values each, borrowed: origin + t * direction in the cylinder's local units.
/// Lengths of directions must lie between 1e-70 and 1e70 (cylinder.h takes any), origins within 1e100.
struct RayArrays {
  const double* origin[3];
  const double* direction[3];
  std::size_t count;
};

/// t[i] = the first crossing of ray i at t >= t_min[i]; infinity if there is none or a value is not finite. Finds the
/// same crossings as intersect() in cylinder.h, from the same formulas, to a few roundings. Open ends drop their
/// crossing. `t` and `t_min` hold rays.count values. Uses the instructions that core/internal/instruction_set.h
/// selects; the result is the same bit for bit for all of them.
void first_crossings(const core::Cylinder& cylinder, const RayArrays& rays, std::span<const double> t_min,
                     gpuprims::Caps caps, std::span<double> t);

}  // namespace sightline::bench
