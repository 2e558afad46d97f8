// Internal to the importers: files that a model file names (materials, buffers, images). Only files in the model's
// directory or below it are opened. Absolute paths, "..", and links that lead out are refused.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

#include "sightline/core/error.h"

namespace sightline::importers {

/// Where the calling thread notes the side files that it looks for, there or not; null: nowhere.
inline thread_local std::vector<std::filesystem::path>* side_files_asked_for = nullptr;

/// Notes them there while it lives.
class SideFileNotes {
 public:
  explicit SideFileNotes(std::vector<std::filesystem::path>& into) { side_files_asked_for = &into; }
  ~SideFileNotes() { side_files_asked_for = nullptr; }
  SideFileNotes(const SideFileNotes&) = delete;
  SideFileNotes& operator=(const SideFileNotes&) = delete;
};

/// The path of the file. `model` is the model file's path. Errors: "'NAME' refused: it lies outside the model's
/// directory", "'NAME' not found".
core::Expected<std::filesystem::path> find_side_file(const std::filesystem::path& model, std::string_view name);

/// The contents of the file. An empty file is an error, and so is one larger than `largest` bytes.
core::Expected<std::vector<std::byte>> read_side_file(const std::filesystem::path& model, std::string_view name,
                                                      std::uint64_t largest = std::uint64_t{1} << 32);

/// Decodes "%" sequences of a URI; other characters stay.
std::string percent_decoded(std::string_view uri);

/// Looks for a name of another system: as written, with '\\' as '/', with %20 and the like decoded, and as UTF-8. The
/// error is that of the name as written.
core::Expected<std::filesystem::path> find_named_file(const std::filesystem::path& model, std::string_view name);

/// The last resort: the name's path below the model's directory, else its last part in that directory, upper and lower
/// case alike. What it finds is a guess, which deserves a warning.
core::Expected<std::filesystem::path> find_similar_file(const std::filesystem::path& model, std::string_view name);

}  // namespace sightline::importers
