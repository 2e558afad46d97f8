#include "sightline/core/internal/atomic_file.h"

#include <atomic>
#include <cassert>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <string>
#include <system_error>
#include <utility>

#include "sightline/core/internal/ascii_case.h"
#include "sightline/core/internal/platform/files.h"

namespace sightline::core {
namespace {

namespace fs = std::filesystem;

/// errno, or EIO where that is 0. A function that sets no errno leaves that of an earlier call; its failure must not
/// get lost.
int last_error() {
  return errno != 0 ? errno : EIO;
}

}  // namespace

Expected<void> expect_extension(const std::filesystem::path& file, std::string_view extension) {
  const std::string found = file.extension().string();
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) return {};  // the writer says that it is one
  if (found.empty() || same_but_for_case(found, extension)) return {};
  return fail(file.string() + ": expected a name that ends in " + std::string(extension));
}

tl::unexpected<Error> cannot_write(const fs::path& target, const std::error_code& reason) {
  return fail(target.string() + ": cannot be written: " + reason.message());
}

fs::path beside(const fs::path& place) {
  static std::atomic<std::uint32_t> next{
      static_cast<std::uint32_t>(std::chrono::system_clock::now().time_since_epoch().count())};
  fs::path path = place;
  path += "." + std::to_string(next++) + ".part";
  return path;
}

Expected<AtomicFile> AtomicFile::create(fs::path target) {
  AtomicFile made;
  made.target_ = std::move(target);
  made.place_ = made.target_;
  std::error_code ignored;
  const fs::file_status status = fs::status(made.target_, ignored);
  if (fs::is_directory(status)) return cannot_write(made.target_, std::make_error_code(std::errc::is_a_directory));
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    made.file_.reset(platform::open_file(made.target_, "wb"));
  } else {
    if (fs::exists(status) && fs::is_symlink(fs::symlink_status(made.target_, ignored)))
      made.place_ = fs::canonical(made.target_, ignored);
    // "x": fails where the file exists, so that no other writer's temporary file is opened.
    do {
      made.temporary_ = beside(made.place_);
      made.file_.reset(platform::open_file(made.temporary_, "wbx"));
    } while (!made.file_ && errno == EEXIST);
  }
  if (!made.file_) return cannot_write(made.target_, {last_error(), std::generic_category()});
  if (fs::is_regular_file(status)) fs::permissions(made.temporary_, status.permissions(), ignored);
  return made;
}

AtomicFile::~AtomicFile() {
  if (!file_) return;
  file_.reset();
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove(temporary_, ignored);
}

bool AtomicFile::write(std::span<const std::byte> bytes) {
  assert(file_ && "no write after commit()");
  if (bytes.empty()) return !failed();  // fwrite() takes no null pointer, of no bytes either
  errno = 0;
  if (!failed() && std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) error_ = last_error();
  return !failed();
}

Expected<void> AtomicFile::commit() {
  assert(file_ && "one commit()");
  errno = 0;
  if (std::fclose(file_.release()) != 0 && !failed()) error_ = last_error();
  std::error_code reason(error_, std::generic_category());
  if (!reason && !temporary_.empty()) platform::replace_file(temporary_, place_, reason);
  if (!reason) return {};
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove(temporary_, ignored);
  return cannot_write(target_, reason);
}

Expected<void> write_file(const fs::path& target, std::initializer_list<std::span<const std::byte>> parts) {
  auto file = AtomicFile::create(target);
  if (!file) return tl::unexpected(file.error());
  for (const std::span<const std::byte> part : parts) file->write(part);
  return file->commit();
}

}  // namespace sightline::core
