// Values of command-line arguments, as texts.
#pragma once

#include <array>
#include <string>

#include "sightline/core/conventions.h"
#include "sightline/core/error.h"

namespace sightline::apps {

/// "640x360", both 1 … 16384.
core::Expected<std::array<int, 2>> parse_size(const std::string& text);
/// "X,Y,Z", finite.
core::Expected<core::dvec3> parse_vector(const std::string& text);
/// A vector other than 0,0,0.
core::Expected<core::dvec3> parse_direction(const std::string& text);
/// A finite number. Option::in_range() lets NaN through.
core::Expected<double> parse_finite(const std::string& text);

// Names of files that are written, so that an extension that their format does not have is refused before any work.
core::Expected<std::string> parse_png_name(const std::string& text);
core::Expected<std::string> parse_pfm_name(const std::string& text);
core::Expected<std::string> parse_svg_name(const std::string& text);

}  // namespace sightline::apps
