// Commands for single sections. N: the number that the tab shows, from 1; without it the selected one.
#pragma once

#include <string>

#include "sightline/core/error.h"

namespace sightline::apps {

class Viewer;

core::Expected<void> select_section(Viewer& viewer, const std::string& number);  ///< 0: none
core::Expected<void> flip_section(Viewer& viewer, const std::string& number);
core::Expected<void> move_section(Viewer& viewer, const std::string& number_and_metres);
core::Expected<void> remove_section(Viewer& viewer, const std::string& number);

}  // namespace sightline::apps
