#include "sightline/tests/fuzz/side_files_in_memory.h"

#include <string>

#include "sightline/importers/side_files.h"

namespace sightline {
namespace {
std::span<const std::span<const std::byte>> files_left;
}  // namespace

void fuzz::set_side_files(std::span<const std::span<const std::byte>> files) {
  files_left = files;
}

core::Expected<std::filesystem::path> importers::find_side_file(const std::filesystem::path&, std::string_view name) {
  return core::fail("'" + std::string(name) + "' not found");
}

core::Expected<std::vector<std::byte>> importers::read_side_file(const std::filesystem::path&, std::string_view name,
                                                                 std::uint64_t largest) {
  if (files_left.empty() || files_left.front().empty() || files_left.front().size() > largest)
    return core::fail("'" + std::string(name) + "' not found");
  const auto file = files_left.front();
  files_left = files_left.subspan(1);
  return std::vector<std::byte>(file.begin(), file.end());
}

}  // namespace sightline
