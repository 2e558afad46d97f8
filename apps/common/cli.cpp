#include "sightline/apps/common/cli.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <new>
#include <span>
#include <sstream>

#include <CLI/CLI.hpp>

#include "sightline/core/internal/atomic_file.h"

namespace sightline::apps {

void add_examples(CLI::App& app, const std::string& examples) {
  app.footer("Examples:\n" + examples);
}

void describe(CLI::App& app, const std::string& examples) {
  app.set_version_flag("--version", std::string("sightline ") + SIGHTLINE_VERSION);
  add_examples(app, examples);
}

void add_json_option(CLI::App& app, std::string& file) {
  app.add_option("--json", file, "Write the figures as JSON to FILE, or - for stdout")->option_text("FILE");
}

int run(CLI::App& app, int argc, char** argv, const std::function<core::Expected<int>()>& body) {
  const std::string tool = app.get_name();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::fprintf(stderr, "%s: %s (see --help)\n", tool.c_str(), error.what());
    return kExitUsage;
  }
  try {
    const core::Expected<int> result = body();
    if (result) return *result;
    if (result.error().message.empty()) return kExitOk;
    std::fprintf(stderr, "%s: %s\n", tool.c_str(), result.error().message.c_str());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "%s: not enough memory\n", tool.c_str());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", tool.c_str(), error.what());
  }
  return kExitFailure;
}

core::Expected<std::array<int, 2>> parse_size(const std::string& text) {
  int width = 0, height = 0, used = 0;
  const bool parsed = std::sscanf(text.c_str(), "%5dx%5d%n", &width, &height, &used) == 2;
  if (!parsed || used != int(text.size()) || width < 1 || height < 1 || width > 16384 || height > 16384)
    return core::fail("expected WIDTHxHEIGHT between 1 and 16384, found \"" + text + "\"");
  return std::array<int, 2>{width, height};
}

core::Expected<core::dvec3> parse_vector(const std::string& text) {
  core::dvec3 v(0.0);
  int used = 0;
  const bool parsed = std::sscanf(text.c_str(), "%lf,%lf,%lf%n", &v.x, &v.y, &v.z, &used) == 3;
  if (!parsed || used != int(text.size()) || !std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z))
    return core::fail("expected X,Y,Z, three finite numbers, found \"" + text + "\"");
  return v;
}

core::Expected<double> parse_finite(const std::string& text) {
  double value = 0.0;
  int used = 0;
  const bool parsed = std::sscanf(text.c_str(), "%lf%n", &value, &used) == 1;
  if (!parsed || used != int(text.size()) || !std::isfinite(value))
    return core::fail("expected a finite number, found \"" + text + "\"");
  return value;
}

core::Expected<void> make_directory(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) return core::fail(path + ": cannot be made a directory: " + error.message());
  return {};
}

core::Expected<void> write_text(const std::string& file, const std::string& text) {
  if (file == "-") {
    std::cout << text << std::flush;
    if (!std::cout) return core::fail("standard output: cannot be written");
    return {};
  }
  return core::write_file(file, {std::as_bytes(std::span(text))});
}

std::FILE* table_stream(const std::string& file) {
  return file == "-" ? stderr : stdout;
}

std::string shell_word(const std::string& word) {
  constexpr const char* kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./,:=+-";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

}  // namespace sightline::apps
