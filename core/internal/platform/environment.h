// Variables of the process's environment. Internal.
#pragma once

#include <optional>
#include <string>

#include "sightline/core/api.h"

namespace sightline::core::platform {

/// In UTF-8; nothing where the variable is not set.
SIGHTLINE_API std::optional<std::string> environment(const char* name);
/// For this process and those that it starts. An empty optional removes the variable.
SIGHTLINE_API void set_environment(const char* name, const std::optional<std::string>& value);

}  // namespace sightline::core::platform
