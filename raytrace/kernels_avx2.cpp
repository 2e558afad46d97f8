// The kernels for AVX2.
#include "sightline/raytrace/internal/kernels_avx.h"

namespace sightline::raytrace {

const Kernels& avx2_kernels() {
  static constexpr Kernels kKernels = make_kernels<Avx2>();
  return kKernels;
}

}  // namespace sightline::raytrace
