// Internal to the importers: parses JSON text to a tree of values that is safe to walk, with readable errors.
#pragma once

#include <string>
#include <string_view>

#include "sightline/core/error.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::importers {

using Json = json::Value;

/// Parses a whole text. Errors read "source: line 3, column 7: expected …". Arrays and objects nested deeper than
/// `max_depth` are an error, found before a value is built. The values take up to 40 bytes for each byte of the text.
core::Expected<Json> parse_json(std::string_view text, std::string_view source, int max_depth);

/// What a value is, for messages: "an array of 3", "the number 7", …
std::string describe(const Json& value);

}  // namespace sightline::importers
