// cylinder_rays.h for AVX512.
#include "sightline/apps/bench/cylinder_rays/cylinder_rays_impl.h"

namespace sightline::bench {

void first_crossings_avx512(const CylinderRays& in) {
  first_crossings(in);
}

}  // namespace sightline::bench
