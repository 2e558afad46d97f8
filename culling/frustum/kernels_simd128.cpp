// The kernels for NEON and WebAssembly's SIMD128.
#include "sightline/culling/frustum/internal/kernels_impl.h"
#include "sightline/culling/frustum/internal/simd_128.h"

namespace sightline::culling {

const FrustumKernels& simd128_frustum_kernels() {
  static constexpr FrustumKernels kKernels = make_frustum_kernels<Simd128>();
  return kKernels;
}

}  // namespace sightline::culling
