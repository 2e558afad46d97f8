// Which instructions the kernels of other folders use (files compiled for one instruction set each). One binary holds
// all forms; the processor decides at run time.
#pragma once

#include <optional>

namespace sightline::core {

/// Every form gives the same answer bit for bit; kScalar is the plain twin of the others.
enum class InstructionSet { kScalar, kAvx2, kAvx512 };

/// Whether this build has the form and this processor can run it.
bool supported(InstructionSet set);
/// The form in use: the widest supported one unless another is forced.
InstructionSet instruction_set();
/// For tests and benchmarks: what follows, on every thread, runs in this form, which must be supported. nullopt: the
/// widest again. Not to be called while another thread runs kernels.
void force_instruction_set(std::optional<InstructionSet> set);
const char* name_of(InstructionSet set);

}  // namespace sightline::core
