// Internal to the writer of 3D Tiles: folders that appear whole or not at all.
#pragma once

#include <filesystem>
#include <functional>

#include "sightline/core/error.h"

namespace sightline::importers {

/// A folder under another name beside its own, until commit(). Before that, and after a failure, readers find what was
/// there. In commit() itself there is a moment between two renames in which they find nothing.
class NewFolder {
 public:
  /// Fails where something is there that `may_replace` does not accept, and where the folder cannot be made. Empty
  /// folders are always accepted.
  static core::Expected<NewFolder> create(const std::filesystem::path& target,
                                          const std::function<bool(const std::filesystem::path&)>& may_replace);
  NewFolder(NewFolder&& other) noexcept;
  NewFolder& operator=(NewFolder&&) = delete;
  ~NewFolder();  ///< removes it, unless commit() was called

  const std::filesystem::path& path() const { return path_; }  ///< where to write
  core::Expected<void> commit();

 private:
  NewFolder() = default;
  std::filesystem::path target_, path_;
};

}  // namespace sightline::importers
