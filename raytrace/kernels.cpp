#include "sightline/raytrace/internal/kernels.h"

#include "sightline/core/internal/instruction_set.h"
#include "sightline/raytrace/internal/packet.h"

namespace sightline::raytrace {

const Kernels& kernels() {
#ifdef SIGHTLINE_X86_KERNELS
  return core::form_in_use(scalar_kernels, avx2_kernels, avx512_kernels)();
#elif defined(SIGHTLINE_NEON_KERNELS)
  return core::form_in_use(scalar_kernels, neon_kernels)();
#else
  return scalar_kernels();
#endif
}

const PacketKernels& packet_kernels() {
#ifdef SIGHTLINE_X86_KERNELS
  return core::form_in_use(scalar_packet_kernels, avx2_packet_kernels, avx512_packet_kernels)();
#elif defined(SIGHTLINE_NEON_KERNELS)
  return core::form_in_use(scalar_packet_kernels, neon_packet_kernels)();
#else
  return scalar_packet_kernels();
#endif
}

}  // namespace sightline::raytrace
