// Files and folders of the operating system, by names in any script. Internal.
//
// Names in text are UTF-8 everywhere. A std::filesystem::path is made of them by path_of(): its own constructor takes
// them for another encoding on Windows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <tl/expected.hpp>

#include "sightline/core/api.h"

namespace sightline::core::platform {

/// The path of this name. Never fails: what is no UTF-8 names no file.
SIGHTLINE_API std::filesystem::path path_of(std::string_view name);
/// The path's name as UTF-8.
SIGHTLINE_API std::string name_of(const std::filesystem::path& path);

/// fopen(): null and errno where it fails. `mode` has a "b", so that a file has the bytes that were written.
SIGHTLINE_API std::FILE* open_file(const std::filesystem::path& path, const char* mode);

/// When a file was last written to, in units of the system and as finely as it knows; 0 and an error where it cannot
/// tell.
SIGHTLINE_API std::int64_t write_time(const std::filesystem::path& path, std::error_code& error);

/// Renames a file. One that had the name is replaced, also while somebody reads it. Where Windows cannot do that at
/// once, there is no file of the name for a moment.
SIGHTLINE_API void replace_file(const std::filesystem::path& from, const std::filesystem::path& to,
                                std::error_code& error);

/// Where this process, and those that it starts, make temporary files from now on.
SIGHTLINE_API void set_temporary_folder(const std::filesystem::path& folder);
/// A new folder that only the user may access, where temporary files lie; empty where none can be made.
SIGHTLINE_API std::filesystem::path make_temporary_folder();

/// The folders of the user in which programs keep things, without the program's own name. Empty where there is none.
SIGHTLINE_API std::filesystem::path cache_folder();
SIGHTLINE_API std::filesystem::path settings_folder();
SIGHTLINE_API std::filesystem::path home_folder();

/// A file that is open to be read. It may be replaced meanwhile: this one stays as it is.
class SIGHTLINE_API ReadableFile {
 public:
  /// Opening a pipe does not wait for a writer.
  static tl::expected<ReadableFile, std::error_code> open(const std::filesystem::path& path);
  ReadableFile() = default;
  ReadableFile(ReadableFile&& other) noexcept { *this = std::move(other); }
  ReadableFile& operator=(ReadableFile&& other) noexcept {
    std::swap(handle_, other.handle_);
    std::swap(regular_, other.regular_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~ReadableFile();

  bool is_open() const { return handle_ != kClosed; }
  bool is_regular() const { return regular_; }  ///< no folder, device or pipe
  std::uint64_t size() const { return size_; }  ///< when it was opened

  /// Copies bytes from `offset` on, and returns how many: fewer than asked where the file ends.
  tl::expected<std::size_t, std::error_code> read(std::uint64_t offset, std::span<std::byte> to) const;

  /// The content in memory, as far as size(); null of an empty file. Where it may be written to, nobody else sees that.
  /// It may outlive this.
  enum class Access { kRead, kWriteCopy };
  tl::expected<std::shared_ptr<std::byte>, std::error_code> map(Access access) const;

 private:
  static constexpr std::intptr_t kClosed = -1;
  std::intptr_t handle_ = kClosed;
  bool regular_ = false;
  std::uint64_t size_ = 0;
};

/// Gives the memory of a part of a mapping back to the system until somebody reads it. Nobody may have written to it.
/// `begin` and `end`: in bytes from the mapping's begin; whole pages between them are meant.
SIGHTLINE_API void set_aside(std::byte* mapping, std::uint64_t begin, std::uint64_t end);

}  // namespace sightline::core::platform
