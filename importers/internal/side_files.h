// Internal to the importers: files that a model file names (materials, buffers, images). Only what lies in the model's
// directory or below is opened, whatever the name says: absolute paths, "..", links that lead out are refused.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

#include "sightline/core/error.h"

namespace sightline::importers {

/// Where the file lies. `model` is the model file's path. Errors: "'NAME' refused: it lies outside the model's
/// directory", "'NAME' not found".
core::Expected<std::filesystem::path> find_side_file(const std::filesystem::path& model, std::string_view name);

/// Its contents. An empty file is an error, as one larger than `largest` bytes is.
core::Expected<std::vector<std::byte>> read_side_file(const std::filesystem::path& model, std::string_view name,
                                                      std::uint64_t largest = std::uint64_t{1} << 32);

}  // namespace sightline::importers
