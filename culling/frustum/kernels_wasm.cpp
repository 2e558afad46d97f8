// The kernels for WebAssembly's SIMD128.
#include "sightline/culling/frustum/internal/kernels_impl.h"
#include "sightline/culling/frustum/internal/simd_wasm.h"

namespace sightline::culling {

const FrustumKernels& wasm_frustum_kernels() {
  static constexpr FrustumKernels kKernels = make_frustum_kernels<Simd128>();
  return kKernels;
}

}  // namespace sightline::culling
