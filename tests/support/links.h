// Symbolic links, which not every system and user may make.
#pragma once

#include <filesystem>

namespace sightline::tests {

/// Whether there is now a link of this name.
inline bool make_link(const std::filesystem::path& target, const std::filesystem::path& name) {
  std::error_code refused;
  std::filesystem::create_symlink(target, name, refused);
  return !refused;
}

}  // namespace sightline::tests
