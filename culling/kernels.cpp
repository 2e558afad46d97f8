#include "sightline/culling/kernels.h"

#include <atomic>
#include <bit>
#include <cassert>

namespace sightline::culling {
namespace {

std::atomic<int> g_forced{-1};

InstructionSet widest() {
  for (const InstructionSet set : {InstructionSet::kAvx512, InstructionSet::kAvx2})
    if (supported(set)) return set;
  return InstructionSet::kScalar;
}

unsigned resolve(const ItemTest& test, std::size_t first, unsigned open, PlaneMask mask) {
  unsigned kept = 0;
  for (; open != 0; open &= open - 1) {
    const std::size_t i = first + std::size_t(std::countr_zero(open));
    const auto& c = test.coordinates;
    const core::Aabb box{{c[0][i], c[1][i], c[2][i]}, {c[3][i], c[4][i], c[5][i]}};
    if (test.exact->visible(box, mask)) kept |= 1u << (i - first);
  }
  return kept;
}

}  // namespace

ItemTest make_item_test(const core::ItemBounds& bounds, const CullPlanes& planes, std::uint32_t view_layers) {
  ItemTest test{};
  for (int axis = 0; axis < 6; ++axis) test.coordinates[axis] = bounds.coordinate(axis);
  test.item_count = bounds.size();
  test.layers = bounds.uses_layers() ? bounds.layers().data() : nullptr;
  test.view_layers = view_layers;
  test.planes = planes.planes();
  test.union_first = planes.union_first();
  test.plane_count = planes.plane_count();
  test.exact = &planes;
  test.resolve = resolve;
  return test;
}

bool supported(InstructionSet set) {
#ifdef SIGHTLINE_X86_KERNELS
  if (set == InstructionSet::kAvx2) return __builtin_cpu_supports("avx2") != 0;
  if (set == InstructionSet::kAvx512)
    return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
           __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512vl") != 0;
#endif
  return set == InstructionSet::kScalar;
}

InstructionSet instruction_set() {
  static const InstructionSet best = widest();
  const int forced = g_forced.load(std::memory_order_relaxed);
  return forced < 0 ? best : InstructionSet(forced);
}

void force_instruction_set(std::optional<InstructionSet> set) {
  assert(!set || supported(*set));
  g_forced = set ? int(*set) : -1;
}

const char* name(InstructionSet set) {
  return set == InstructionSet::kScalar ? "scalar" : set == InstructionSet::kAvx2 ? "avx2" : "avx512";
}

const Kernels& kernels() {
#ifdef SIGHTLINE_X86_KERNELS
  switch (instruction_set()) {
    case InstructionSet::kAvx512:
      return avx512_kernels();
    case InstructionSet::kAvx2:
      return avx2_kernels();
    default:
      break;
  }
#endif
  return scalar_kernels();
}

}  // namespace sightline::culling
