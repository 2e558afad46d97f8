#include "sightline/lod/internal/deviation_kernels.h"

#include "sightline/core/internal/instruction_set.h"

namespace sightline::lod {

const DeviationKernels& deviation_kernels() {
#ifdef SIGHTLINE_X86_KERNELS
  return core::form_in_use(scalar_deviation_kernels, avx2_deviation_kernels, avx2_deviation_kernels)();
#elif defined(SIGHTLINE_NEON_KERNELS)
  return core::form_in_use(scalar_deviation_kernels, neon_deviation_kernels)();
#else
  return scalar_deviation_kernels();
#endif
}

}  // namespace sightline::lod
