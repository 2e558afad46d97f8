// The plain form of the kernels: the reference for the others, and the form for other processors.
#include "sightline/culling/frustum/internal/simd_scalar.h"
#include "sightline/culling/occlusion/internal/kernels_impl.h"

namespace sightline::culling {

const OcclusionKernels& scalar_occlusion_kernels() {
  static constexpr OcclusionKernels kKernels = make_occlusion_kernels<Scalar>();
  return kKernels;
}

}  // namespace sightline::culling
