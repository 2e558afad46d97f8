#include "sightline/importers/tiles/internal/new_folder.h"

#include <system_error>
#include <utility>

#include "sightline/core/internal/atomic_file.h"

namespace sightline::importers {

namespace fs = std::filesystem;
using core::beside;
using core::cannot_write;

core::Expected<NewFolder> NewFolder::create(const fs::path& target,
                                            const std::function<bool(const fs::path&)>& may_replace) {
  std::error_code reason;
  NewFolder made;
  made.target_ = fs::weakly_canonical(target, reason);
  if (reason) return cannot_write(target, reason);
  if (!made.target_.has_filename()) made.target_ = made.target_.parent_path();  // "name/"
  const bool there = fs::exists(made.target_, reason);
  if (there && !fs::is_directory(made.target_, reason))
    return core::fail(target.string() + ": expected a folder or a new name, found a file");
  if (there && !fs::is_empty(made.target_, reason) && !may_replace(made.target_))
    return core::fail(target.string() + ": holds files that are not a tileset of this program and would be lost");
  if (reason) return cannot_write(target, reason);
  const fs::path place = beside(made.target_);
  if (!fs::create_directory(place, reason)) return cannot_write(target, reason);
  made.path_ = place;
  return made;
}

NewFolder::NewFolder(NewFolder&& other) noexcept
    : target_(std::move(other.target_)), path_(std::exchange(other.path_, {})) {}

NewFolder::~NewFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

core::Expected<void> NewFolder::commit() {
  std::error_code reason, ignored;
  const fs::path former = beside(target_);
  const bool there = fs::exists(target_, ignored);
  if (there) fs::rename(target_, former, reason);
  if (reason) return cannot_write(target_, reason);
  fs::rename(path_, target_, reason);
  if (reason && there) fs::rename(former, target_, ignored);
  if (reason) return cannot_write(target_, reason);
  path_.clear();
  if (there) fs::remove_all(former, ignored);
  return {};
}

}  // namespace sightline::importers
