// Text in HTML, SVG and CSV.
#pragma once

#include <string>
#include <string_view>

namespace sightline::apps {

/// Text as the content of an element or the value of an attribute. It may hold any bytes: markup characters become
/// references; what is no UTF-8, and characters that XML does not allow, become U+FFFD.
std::string escaped(std::string_view text);

/// A field of CSV (RFC 4180), quoted where it must be.
std::string csv_field(const std::string& text, char separator = ',');

}  // namespace sightline::apps
