// Text and JSON that tools write to files or to standard output.
#pragma once

#include <cstdio>
#include <string>

#include "sightline/core/error.h"

namespace sightline::apps {

/// Indented JSON text with a line end. File and node names may hold any bytes: invalid UTF-8 is replaced.
template <class Json>
std::string to_text(const Json& json) {
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// Makes a directory and its parents where they are missing.
core::Expected<void> make_directory(const std::string& path);

/// Writes text to a file, or to stdout for "-".
core::Expected<void> write_text(const std::string& file, const std::string& text);

/// Writes like write_text(); does nothing if `file` is empty.
template <class Json>
core::Expected<void> write_json(const std::string& file, const Json& json) {
  return file.empty() ? core::Expected<void>() : write_text(file, to_text(json));
}

/// Stream for output that people read: stdout, or stderr if `file` is "-" and other output goes to stdout.
std::FILE* table_stream(const std::string& file);

}  // namespace sightline::apps
