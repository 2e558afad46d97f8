// Commands for single sections. N: the number that the tab shows, from 1; without it the selected one.
#pragma once

#include <optional>
#include <string>

#include "sightline/core/error.h"
#include "sightline/engine/pick.h"

namespace sightline::apps {

class Viewer;

/// Cuts away what lies in front of a face. Fails where there is none, or no room for another section.
core::Expected<void> cut_at(Viewer& viewer, const core::Expected<std::optional<engine::Pick>>& face);
/// Cuts the model in halves across an axis.
core::Expected<void> cut_middle(Viewer& viewer, int axis);
core::Expected<void> select_section(Viewer& viewer, const std::string& number);  ///< 0: none
core::Expected<void> flip_section(Viewer& viewer, const std::string& number);
core::Expected<void> move_section(Viewer& viewer, const std::string& number_and_metres);
core::Expected<void> remove_section(Viewer& viewer, const std::string& number);

}  // namespace sightline::apps
