// The library's own culler in the forms that the study measures.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/internal/instruction_set.h"
#include "sightline/study/method.h"

namespace sightline::study {

struct ProductionForm {
  std::string name;
  std::optional<core::InstructionSet> instructions;  ///< nullopt: the widest that the processor has
  bool list_ids = false;                             ///< also write every visible box's index; otherwise ranges
  bool hierarchy = true;                             ///< false: the linear culler
};

/// The plain form, "production", first; then those that this processor can run. All use one thread.
std::vector<ProductionForm> production_forms();

/// Every form gives one and the same set. Forces its instruction set while it culls, so that one
/// method culls at a time.
std::unique_ptr<Method> make_production(const ProductionForm& form, std::span<const core::Aabb> boxes);

}  // namespace sightline::study
