// Text in encodings that the system knows. Internal.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "sightline/core/api.h"

namespace sightline::core::platform {

/// UTF-8 of a text in an encoding of this name, such as "ISO-8859-1" or "Latin-1". Nothing where the system does not
/// know the name, or the text is not in the encoding.
SIGHTLINE_API std::optional<std::string> decoded(std::string_view text, std::string_view encoding);

}  // namespace sightline::core::platform
