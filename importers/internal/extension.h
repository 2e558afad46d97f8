// Extensions of files, by which formats are told. Internal to the importers.
#pragma once

#include <filesystem>
#include <string>

namespace sightline::importers {

/// With its dot; letters of ASCII in lower case.
inline std::string lower_case_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return extension;
}

}  // namespace sightline::importers
