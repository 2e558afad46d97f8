#include "sightline/raytrace/internal/kernels.h"

#include "sightline/core/internal/instruction_set.h"

namespace sightline::raytrace {

const Kernels& kernels() {
#ifdef SIGHTLINE_X86_KERNELS
  switch (core::instruction_set()) {
    case core::InstructionSet::kAvx512:
      return avx512_kernels();
    case core::InstructionSet::kAvx2:
      return avx2_kernels();
    default:
      break;
  }
#endif
  return scalar_kernels();
}

}  // namespace sightline::raytrace
