// The kernels of cylinder_rays.h, one for each instruction set. Internal.
#pragma once

#include <cstddef>

namespace sightline::bench {

struct CylinderRays {
  const double* origin[3];
  const double* direction[3];
  const double* t_min;
  double* t;
  std::size_t count;
  double radius, half, weight;  ///< weight: of z in closest_approach()
  double least;                 ///< squared part of a direction across the axis; if less, the direction is parallel
  double infinity;
  bool bottom_open, top_open;
};

void first_crossings_avx2(const CylinderRays& in);
void first_crossings_avx512(const CylinderRays& in);

}  // namespace sightline::bench
