// Files that appear whole or not at all.
#pragma once

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <span>
#include <string_view>
#include <system_error>

#include "sightline/core/error.h"

namespace sightline::core {

/// The new content of a file, kept in a temporary file in the same directory until commit() renames it. Before that,
/// and after any failure, readers find the old content. Of several writers of one target, in any process, the last to
/// commit wins; they never mix.
///
/// An existing file's permissions are kept. A symbolic link is followed: the file it leads to is replaced. A target
/// that is not a regular file (a device, a pipe) cannot be replaced and is written to directly. Data is not forced onto
/// the disk: the promise covers the end of the process at any point, not the loss of power.
class AtomicFile {
 public:
  /// Fails where `target` is a directory, and where its directory does not exist or does not take files.
  static Expected<AtomicFile> create(std::filesystem::path target);
  AtomicFile(AtomicFile&&) = default;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile();  ///< removes the temporary file, unless commit() was called

  /// Appends. Returns false after any failure; commit() tells its reason.
  bool write(std::span<const std::byte> bytes);
  bool failed() const { return error_ != 0; }
  /// Replaces the target. Fails when any write did. The temporary file is gone in both cases, and no call may follow.
  Expected<void> commit();

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  AtomicFile() = default;

  std::filesystem::path target_;
  std::filesystem::path place_, temporary_;  // temporary_ becomes place_; empty where the target is written to directly
  std::unique_ptr<std::FILE, Close> file_;   // null once committed
  int error_ = 0;                            // errno of the first failure
};

/// Fails where a file's name has another extension than this one, any case: no format is written under the name of
/// another. A name without any is good, so that it may be that of a device; so is that of a folder, which writing
/// refuses.
Expected<void> expect_extension(const std::filesystem::path& file, std::string_view extension);

/// A name beside `place` that is very probably free: for what will be renamed to it.
std::filesystem::path beside(const std::filesystem::path& place);
tl::unexpected<Error> cannot_write(const std::filesystem::path& target, const std::error_code& reason);

/// Replaces the content of `target` by the `parts`, one after the other.
Expected<void> write_file(const std::filesystem::path& target, std::initializer_list<std::span<const std::byte>> parts);

}  // namespace sightline::core
