// Runs a check in every form of the kernels.
#pragma once

#include <optional>

#include <gtest/gtest.h>

#include "sightline/core/internal/instruction_set.h"

namespace sightline::tests {

/// Runs `check` on a stack that lies so many times 16 bytes further down. Callers align it to no more than that.
template <class Check>
[[gnu::noinline]] void on_moved_stack(unsigned times, const Check& check) {
  volatile char* const room = static_cast<char*>(__builtin_alloca(16 * times + 1));
  room[0] = 0;
  check();
}

/// Runs `check` in every form of the kernels that this machine has and SIGHTLINE_ISA allows, on stacks that wide
/// registers may or may not be aligned on. Counts that a test expects belong outside of `check`: inside they would grow
/// with the number of forms.
template <class Check>
void for_each_instruction_set(const Check& check) {
  for (const auto set : core::kInstructionSets) {
    if (!core::supported(set)) continue;
    SCOPED_TRACE(core::name_of(set));
    core::force_instruction_set(set);
    static unsigned turn = 0;
    on_moved_stack(turn++ % 4, check);
  }
  core::force_instruction_set(std::nullopt);
}

}  // namespace sightline::tests
