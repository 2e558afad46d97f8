// Extensions of files, by which formats are told. Internal to the importers.
#pragma once

#include <filesystem>
#include <string>

#include "sightline/core/internal/ascii_case.h"

namespace sightline::importers {

/// With its dot; letters of ASCII in lower case.
inline std::string lower_case_extension(const std::filesystem::path& path) {
  return core::lower_case(path.extension().string());
}

}  // namespace sightline::importers
