// The kernels for AVX-512.
#include "sightline/culling/frustum/internal/simd_avx512.h"
#include "sightline/culling/occlusion/internal/kernels_impl.h"

namespace sightline::culling {

const OcclusionKernels& avx512_occlusion_kernels() {
  static constexpr OcclusionKernels kKernels = make_occlusion_kernels<Avx512>();
  return kKernels;
}

}  // namespace sightline::culling
