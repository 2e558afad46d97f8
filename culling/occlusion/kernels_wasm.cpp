// The kernels for WebAssembly's SIMD128.
#include "sightline/culling/frustum/internal/simd_wasm.h"
#include "sightline/culling/occlusion/internal/kernels_impl.h"

namespace sightline::culling {

const OcclusionKernels& wasm_occlusion_kernels() {
  static constexpr OcclusionKernels kKernels = make_occlusion_kernels<Simd128>();
  return kKernels;
}

}  // namespace sightline::culling
