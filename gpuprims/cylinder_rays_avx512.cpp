// cylinder_rays.h for AVX512.
#include "sightline/gpuprims/internal/cylinder_rays_impl.h"

namespace sightline::gpuprims {

void first_crossings_avx512(const CylinderRays& in) {
  first_crossings(in);
}

}  // namespace sightline::gpuprims
