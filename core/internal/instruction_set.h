// Which instruction set the kernels of other folders use. Each kernel file is compiled for one instruction set. One
// binary holds all forms; the processor decides at run time which one runs.
#pragma once

#include <optional>
#include <string_view>

namespace sightline::core {

/// From narrow to wide. Every form gives the same answer bit for bit; kScalar is the plain twin of the others.
enum class InstructionSet { kScalar, kNeon, kAvx2, kAvx512 };
inline constexpr InstructionSet kInstructionSets[] = {InstructionSet::kScalar, InstructionSet::kNeon,
                                                      InstructionSet::kAvx2, InstructionSet::kAvx512};

/// Whether this build has the form, this processor can run it, and the environment variable SIGHTLINE_ISA allows it.
/// That variable names the widest form to use (scalar, neon, avx2 or avx512), so that a processor can stand for a
/// narrower one; any other value is ignored. It is read once.
bool supported(InstructionSet set);
/// The form in use: the widest supported one unless another is forced.
InstructionSet instruction_set();
/// For tests and benchmarks: all kernels, on every thread, use this form from now on. It must be supported. nullopt:
/// the widest form again. Not to be called while another thread runs kernels.
void force_instruction_set(std::optional<InstructionSet> set);
const char* name_of(InstructionSet set);
/// The reverse of name_of(); nullopt for any other text.
std::optional<InstructionSet> instruction_set_named(std::string_view name);

/// The form that belongs to the instruction set in use.
template <class Form>
const Form& form_in_use(const Form& scalar, const Form& avx2, const Form& avx512) {
  switch (instruction_set()) {
    case InstructionSet::kAvx512:
      return avx512;
    case InstructionSet::kAvx2:
      return avx2;
    default:
      return scalar;
  }
}
template <class Form>
const Form& form_in_use(const Form& scalar, const Form& neon) {
  return instruction_set() == InstructionSet::kNeon ? neon : scalar;
}

}  // namespace sightline::core
