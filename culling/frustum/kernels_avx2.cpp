// The kernels for AVX2.
#include "sightline/culling/frustum/internal/kernels_impl.h"
#include "sightline/culling/frustum/internal/simd_avx2.h"

namespace sightline::culling {

const FrustumKernels& avx2_frustum_kernels() {
  static constexpr FrustumKernels kKernels = make_frustum_kernels<Avx2>();
  return kKernels;
}

}  // namespace sightline::culling
