#include "sightline/core/internal/instruction_set.h"

#include <cstdlib>

#include <gtest/gtest.h>

namespace sightline::core::instruction_set_test {
namespace {

TEST(InstructionSet, NamesAreUnderstood) {
  for (const InstructionSet set : kInstructionSets) EXPECT_EQ(instruction_set_named(name_of(set)), set);
  for (const char* name : {"", "sse", "AVX2", "avx", "avx2 "}) EXPECT_EQ(instruction_set_named(name), std::nullopt);
}

#if defined(SIGHTLINE_NEON_KERNELS)

TEST(InstructionSet, IsNeonOnEveryArmOf64Bits) {
  const char* name = std::getenv("SIGHTLINE_ISA");
  const bool scalar = name && instruction_set_named(name) == InstructionSet::kScalar;
  EXPECT_EQ(supported(InstructionSet::kNeon), !scalar);
  EXPECT_EQ(instruction_set(), scalar ? InstructionSet::kScalar : InstructionSet::kNeon);
  EXPECT_FALSE(supported(InstructionSet::kAvx2));
}

#endif

}  // namespace
}  // namespace sightline::core::instruction_set_test

#if defined(SIGHTLINE_X86_KERNELS)

// What the compiler's own __builtin_cpu_supports() reads: part of its ABI, as its answers are compiled into programs.
struct CpuModel {
  unsigned vendor, type, subtype, features;
};
extern "C" CpuModel __cpu_model;

namespace sightline::core::instruction_set_test {
namespace {

/// The form that SIGHTLINE_ISA names, or the widest.
InstructionSet widest_allowed() {
  const char* name = std::getenv("SIGHTLINE_ISA");
  return name && *name ? instruction_set_named(name).value() : InstructionSet::kAvx512;
}

/// Whether the processor has the instructions that kernels are compiled for (cmake/SightlineTargets.cmake), and may use
/// them.
bool has_all_for(InstructionSet set) {
  if (set > widest_allowed()) return false;
  const bool common =
      __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("popcnt");
  if (set == InstructionSet::kAvx2) return common && __builtin_cpu_supports("avx2");
  return common && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}

/// A processor without one of its features, each in turn.
TEST(InstructionSet, NeedsAllThatItsKernelsUse) {
  const unsigned features = __cpu_model.features;
  const auto pretend = [](unsigned word) {
    __cpu_model.features = word;
    asm volatile("" ::: "memory");
  };
  int denied = 0;
  for (int bit = -1; bit < 32; ++bit) {
    pretend(bit < 0 ? features : features & ~(1u << bit));
    for (const InstructionSet set : {InstructionSet::kAvx2, InstructionSet::kAvx512}) {
      EXPECT_EQ(supported(set), has_all_for(set)) << name_of(set) << " without feature " << bit;
      denied += !supported(set);
    }
    EXPECT_TRUE(supported(InstructionSet::kScalar));
  }
  pretend(features);
  if (has_all_for(InstructionSet::kAvx2)) {
    EXPECT_GE(denied, 4) << "no feature was taken away";
  }
}

}  // namespace
}  // namespace sightline::core::instruction_set_test

#endif
