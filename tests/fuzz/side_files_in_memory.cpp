#include "sightline/tests/fuzz/side_files_in_memory.h"

#include <algorithm>
#include <string>
#include <vector>

#include "sightline/importers/internal/side_files.h"

namespace sightline {
namespace {

std::span<const std::span<const std::byte>> files;
std::vector<std::filesystem::path> names;  // of files, as far as asked for

/// Number of the file of that name; `files.size()` when there is none.
std::size_t place_of(const std::filesystem::path& name) {
  const auto known = std::find(names.begin(), names.end(), name);
  const auto place = std::size_t(known - names.begin());
  if (place == files.size()) return place;
  if (known == names.end()) names.push_back(name);
  return files[place].empty() ? files.size() : place;
}

}  // namespace

void fuzz::set_side_files(std::span<const std::span<const std::byte>> contents) {
  files = contents;
  names.clear();
}

core::Expected<std::filesystem::path> importers::find_side_file(const std::filesystem::path&, std::string_view name) {
  std::filesystem::path path = std::filesystem::path(name).lexically_normal();
  if (place_of(path) == files.size()) return core::fail("'" + std::string(name) + "' not found");
  return path;
}

core::Expected<std::vector<std::byte>> importers::read_side_file(const std::filesystem::path& model,
                                                                 std::string_view name, std::uint64_t largest) {
  const auto path = find_side_file(model, name);
  if (!path) return tl::unexpected(path.error());
  const auto file = files[place_of(*path)];
  if (file.size() > largest) return core::fail("'" + std::string(name) + "' is refused: too large");
  return std::vector<std::byte>(file.begin(), file.end());
}

core::Expected<std::filesystem::path> importers::find_similar_file(const std::filesystem::path&,
                                                                   std::string_view name) {
  return core::fail("'" + std::string(name) + "' not found");
}

}  // namespace sightline
