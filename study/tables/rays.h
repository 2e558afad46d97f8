// Internal to sightline-study: the subcommand `rays`, which compares structures and traversals of ray tracing.
#pragma once

#include <functional>
#include <string>

#include "sightline/core/error.h"

namespace sightline::apps {
class CommandLine;
}

namespace sightline::study {

/// Adds the options to the subcommand, and returns what runs it.
std::function<core::Expected<int>()> add_rays(apps::CommandLine& line);

/// In quotes, where the text has a comma.
std::string csv_field(const std::string& text);

}  // namespace sightline::study
