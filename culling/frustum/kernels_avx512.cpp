// The kernels for AVX-512.
#include "sightline/culling/frustum/internal/kernels_impl.h"
#include "sightline/culling/frustum/internal/simd_avx512.h"

namespace sightline::culling {

const FrustumKernels& avx512_frustum_kernels() {
  static constexpr FrustumKernels kKernels = make_frustum_kernels<Avx512>();
  return kKernels;
}

}  // namespace sightline::culling
