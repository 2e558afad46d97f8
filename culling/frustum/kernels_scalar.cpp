// The plain form of the kernels: the reference for the others, and the form for other processors.
#include "sightline/culling/frustum/internal/kernels_impl.h"
#include "sightline/culling/frustum/internal/simd_scalar.h"

namespace sightline::culling {

const FrustumKernels& scalar_frustum_kernels() {
  static constexpr FrustumKernels kKernels = make_frustum_kernels<Scalar>();
  return kKernels;
}

}  // namespace sightline::culling
