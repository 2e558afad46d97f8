// Command-line parsing, exit codes and one-line errors, shared by all tools.
#pragma once

#include <array>
#include <cstdio>
#include <functional>
#include <string>

#include "sightline/core/conventions.h"
#include "sightline/core/error.h"

namespace CLI {
class App;  // <CLI/CLI.hpp> costs four seconds a file: only files that define options include it
}

namespace sightline::apps {

inline constexpr int kExitOk = 0;
inline constexpr int kExitFailure = 1;  ///< bad input or a failed comparison
inline constexpr int kExitUsage = 2;

/// Puts `examples`, lines that begin with two spaces, below the help text.
void add_examples(CLI::App& app, const std::string& examples);
/// Adds --version and examples.
void describe(CLI::App& app, const std::string& examples);
/// --json FILE, into `file`.
void add_json_option(CLI::App& app, std::string& file);

/// Parses the command line and runs a tool. Its error becomes one line on stderr and exit 1. One without a message is
/// that of another process, which tells it: exit 0, or mpirun would end that one before it can. Bad usage gives exit 2.
/// An exception of a library (no memory) gives exit 1.
int run(CLI::App& app, int argc, char** argv, const std::function<core::Expected<int>()>& body);

/// "640x360", both 1 … 16384.
core::Expected<std::array<int, 2>> parse_size(const std::string& text);
/// "X,Y,Z", finite.
core::Expected<core::dvec3> parse_vector(const std::string& text);

/// A finite number. CLI11's ranges let NaN through.
core::Expected<double> parse_finite(const std::string& text);

/// Makes a parser an option's check. Text that it refuses is bad usage.
template <class T>
std::function<std::string(const std::string&)> accepted_by(core::Expected<T> (*parse)(const std::string&)) {
  return [parse](const std::string& text) {
    const auto parsed = parse(text);
    return parsed ? std::string() : parsed.error().message;
  };
}

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

/// A word as a shell takes it, quoted where that is needed.
std::string shell_word(const std::string& word);

}  // namespace sightline::apps
