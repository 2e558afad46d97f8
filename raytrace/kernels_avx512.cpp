// The kernels for AVX-512 (F, BW, DQ, VL): registers of 256 bits, of which there are twice as many.
#include "sightline/raytrace/internal/kernels_avx.h"

namespace sightline::raytrace {

const Kernels& avx512_kernels() {
  static constexpr Kernels kKernels = make_kernels<Avx2>();
  return kKernels;
}

}  // namespace sightline::raytrace
