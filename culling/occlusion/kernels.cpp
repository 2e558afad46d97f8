#include "sightline/culling/occlusion/internal/kernels.h"

#include "sightline/core/internal/instruction_set.h"

namespace sightline::culling {

const OcclusionKernels& occlusion_kernels() {
#ifdef SIGHTLINE_X86_KERNELS
  return core::form_in_use(scalar_occlusion_kernels, avx2_occlusion_kernels, avx512_occlusion_kernels)();
#elif defined(SIGHTLINE_NEON_KERNELS)
  return core::form_in_use(scalar_occlusion_kernels, simd128_occlusion_kernels)();
#elif defined(SIGHTLINE_WASM_KERNELS)
  return simd128_occlusion_kernels();
#else
  return scalar_occlusion_kernels();
#endif
}

}  // namespace sightline::culling
