// What the viewer tells of a model as a whole. No window.
#pragma once

#include <string>
#include <vector>

#include "sightline/apps/common/item_facts.h"
#include "sightline/apps/view/file_states.h"
#include "sightline/core/item_bounds.h"

namespace sightline::apps {

/// Files with their sizes, number of items, extents.
std::vector<Fact> model_facts(const std::vector<std::string>& files, FileStates& states, const core::Scene& scene,
                              const core::AabbD& bounds, const LengthFormat& lengths);

/// Items about which something is odd.
struct Finding {
  std::string words;
  std::vector<core::ItemId> items;  ///< in rising order
};
/// Items too far away from all others, which fitted views leave out, and items without volume; only what there is.
std::vector<Finding> findings(const core::Scene& scene, const core::FittedBounds& fitted);

}  // namespace sightline::apps
