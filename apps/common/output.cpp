#include "sightline/apps/common/output.h"

#include <filesystem>
#include <iostream>
#include <span>
#include <system_error>

#include "sightline/core/internal/atomic_file.h"
#include "sightline/core/internal/platform/files.h"

namespace sightline::apps {

std::string to_text(const json::Value& json) {
  return json.dump(1) + "\n";
}

core::Expected<void> expect_output(std::initializer_list<const std::string*> files) {
  for (const std::string* file : files)
    if (!file->empty()) return {};
  return core::fail("--out is required: expected the name of the image, such as --out image.png");
}

core::Expected<void> make_directory(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(core::platform::path_of(path), error);
  if (error) return core::fail(path + ": cannot be made a directory: " + error.message());
  return {};
}

core::Expected<void> write_text(const std::string& file, const std::string& text) {
  if (file == "-") {
    std::cout << text << std::flush;
    if (!std::cout) return core::fail("standard output: cannot be written");
    return {};
  }
  return core::write_file(core::platform::path_of(file), {std::as_bytes(std::span(text))});
}

core::Expected<void> write_json(const std::string& file, const json::Value& json) {
  return file.empty() ? core::Expected<void>() : write_text(file, to_text(json));
}

std::FILE* table_stream(const std::string& file) {
  return file == "-" ? stderr : stdout;
}

}  // namespace sightline::apps
