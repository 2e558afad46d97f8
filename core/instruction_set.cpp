#include "sightline/core/internal/instruction_set.h"

#include <atomic>
#include <cassert>
#include <cstdlib>

namespace sightline::core {
namespace {

std::atomic<int> g_forced{-1};

InstructionSet widest() {
  InstructionSet widest = InstructionSet::kScalar;
  for (const InstructionSet set : kInstructionSets)
    if (supported(set)) widest = set;
  return widest;
}

InstructionSet widest_allowed() {
  const char* name = std::getenv("SIGHTLINE_ISA");
  return instruction_set_named(name ? name : "").value_or(InstructionSet::kAvx512);
}

}  // namespace

bool supported(InstructionSet set) {
  static const InstructionSet limit = widest_allowed();
  if (set > limit) return false;
#ifdef SIGHTLINE_X86_KERNELS
    // The build defines both conditions, of the features that it compiles kernels for (cmake/SightlineTargets.cmake).
#define SIGHTLINE_HAS(feature) (__builtin_cpu_supports(#feature) != 0)
  if (set == InstructionSet::kAvx2) return SIGHTLINE_HAS_AVX2;
  if (set == InstructionSet::kAvx512) return SIGHTLINE_HAS_AVX512;
#elif defined(SIGHTLINE_NEON_KERNELS)
  if (set == InstructionSet::kNeon) return true;  // every processor of 64 bits has it
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

const char* name_of(InstructionSet set) {
  static constexpr const char* kNames[] = {"scalar", "neon", "avx2", "avx512"};
  return kNames[int(set)];
}

std::optional<InstructionSet> instruction_set_named(std::string_view name) {
  for (const InstructionSet set : kInstructionSets)
    if (name == name_of(set)) return set;
  return std::nullopt;
}

}  // namespace sightline::core
