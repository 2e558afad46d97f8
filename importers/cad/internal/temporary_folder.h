// Internal to the importers: a folder for files that another library or process reads by name.
#pragma once

#include <filesystem>
#include <system_error>

#include "sightline/core/internal/platform/files.h"

namespace sightline::importers {

/// A folder that is gone when this is.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_(core::platform::make_temporary_folder()) {}
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }  ///< empty: none can be made

 private:
  std::filesystem::path path_;
};

}  // namespace sightline::importers
