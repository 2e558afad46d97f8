// Command lines and terminals. Internal.
#pragma once

#include <string>
#include <vector>

#include "sightline/core/api.h"

namespace sightline::core::platform {

/// The arguments of main() in UTF-8. What the process prints is from then on UTF-8, with the bytes that it writes.
SIGHTLINE_API std::vector<std::string> begin_program(int argc, char** argv);

/// A word as the system's shell takes it, quoted where that is needed.
SIGHTLINE_API std::string shell_word(const std::string& word);

/// Whether somebody watches standard error, and it understands escape sequences.
SIGHTLINE_API bool errors_are_on_terminal();

}  // namespace sightline::core::platform
