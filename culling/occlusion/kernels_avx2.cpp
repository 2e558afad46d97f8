// The kernels for AVX2.
#include "sightline/culling/frustum/internal/simd_avx2.h"
#include "sightline/culling/occlusion/internal/kernels_impl.h"

namespace sightline::culling {

const OcclusionKernels& avx2_occlusion_kernels() {
  static constexpr OcclusionKernels kKernels = make_occlusion_kernels<Avx2>();
  return kKernels;
}

}  // namespace sightline::culling
