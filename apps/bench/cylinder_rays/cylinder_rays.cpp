#include "sightline/apps/bench/cylinder_rays/cylinder_rays.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "sightline/apps/bench/cylinder_rays/cylinder_rays_impl.h"
#include "sightline/core/internal/instruction_set.h"
#include "sightline/gpuprims/internal/local_ray.h"

namespace sightline::bench {

void first_crossings(const core::Cylinder& cylinder, const RayArrays& rays, std::span<const double> t_min,
                     gpuprims::Caps caps, std::span<double> t) {
  assert(t_min.size() >= rays.count && t.size() >= rays.count);
  const double radius = std::fabs(cylinder.radius), half = 0.5 * std::fabs(cylinder.height);
  if (!(radius > 0.0 && std::isfinite(radius + half))) {
    std::fill_n(t.begin(), rays.count, std::numeric_limits<double>::infinity());
    return;
  }
  const CylinderRays in{{rays.origin[0], rays.origin[1], rays.origin[2]},
                        {rays.direction[0], rays.direction[1], rays.direction[2]},
                        t_min.data(),
                        t.data(),
                        rays.count,
                        radius,
                        half,
                        gpuprims::weight(radius, half),
                        1024 * std::numeric_limits<double>::min(),
                        std::numeric_limits<double>::infinity(),
                        !caps.bottom,
                        !caps.top};
#ifdef SIGHTLINE_X86_KERNELS
  core::form_in_use(first_crossings, first_crossings_avx2, first_crossings_avx512)(in);
#else
  first_crossings(in);
#endif
}

}  // namespace sightline::bench
