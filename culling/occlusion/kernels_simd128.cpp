// The kernels for NEON and WebAssembly's SIMD128.
#include "sightline/culling/frustum/internal/simd_128.h"
#include "sightline/culling/occlusion/internal/kernels_impl.h"

namespace sightline::culling {

const OcclusionKernels& simd128_occlusion_kernels() {
  static constexpr OcclusionKernels kKernels = make_occlusion_kernels<Simd128>();
  return kKernels;
}

}  // namespace sightline::culling
