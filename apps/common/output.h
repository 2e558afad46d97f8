// Text and JSON that tools write to files or to standard output.
#pragma once

#include <cstdio>
#include <initializer_list>
#include <string>

#include "sightline/core/error.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

/// Indented JSON text with a line end. File and node names may hold any bytes: invalid UTF-8 is replaced.
std::string to_text(const json::Value& json);

/// Refuses to make an image for nobody: fails where all of these names of files are empty.
core::Expected<void> expect_output(std::initializer_list<const std::string*> files);

/// Makes a directory and its parents where they are missing.
core::Expected<void> make_directory(const std::string& path);

/// Writes text to a file, or to stdout for "-".
core::Expected<void> write_text(const std::string& file, const std::string& text);

/// Writes like write_text(); does nothing if `file` is empty.
core::Expected<void> write_json(const std::string& file, const json::Value& json);

/// Stream for output that people read: stdout, or stderr if `file` is "-" and other output goes to stdout.
std::FILE* table_stream(const std::string& file);

}  // namespace sightline::apps
