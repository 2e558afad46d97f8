// Runs a check in every form of the kernels.
#pragma once

#include <optional>

#include <gtest/gtest.h>

#include "sightline/core/internal/instruction_set.h"

namespace sightline::tests {

/// Runs `check` in every form of the kernels that this machine has and SIGHTLINE_ISA allows. Counts that a test expects
/// belong outside of `check`: inside they would grow with the number of forms.
template <class Check>
void for_each_instruction_set(const Check& check) {
  for (const auto set : core::kInstructionSets) {
    if (!core::supported(set)) continue;
    SCOPED_TRACE(core::name_of(set));
    core::force_instruction_set(set);
    check();
  }
  core::force_instruction_set(std::nullopt);
}

}  // namespace sightline::tests
