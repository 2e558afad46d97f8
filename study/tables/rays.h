// Internal to sightline-study: the subcommand `rays`, which compares structures and traversals of ray tracing.
#pragma once

#include <functional>
#include <string>

#include "sightline/core/error.h"

namespace CLI {
class App;
}

namespace sightline::study {

/// Adds the options to the subcommand's app, and returns what runs it.
std::function<core::Expected<int>()> add_rays(CLI::App& app);

/// In quotes, where the text has a comma.
std::string csv_field(const std::string& text);

}  // namespace sightline::study
