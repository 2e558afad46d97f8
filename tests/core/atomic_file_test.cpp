// Files that appear whole or not at all: what readers find before, after and instead.
#include "sightline/core/internal/atomic_file.h"

#include <atomic>
#include <chrono>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/internal/platform/files.h"
#include "sightline/tests/support/full_disk.h"
#include "sightline/tests/support/links.h"

namespace sightline::core::atomic_file_test {
namespace {

namespace fs = std::filesystem;

constexpr bool kPosix = fs::path::preferred_separator == '/';

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}

class AtomicFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    static int count = 0;
    const auto now = std::chrono::system_clock::now().time_since_epoch().count();
    folder_ =
        fs::path(testing::TempDir()) / ("sightline-atomic-file-" + std::to_string(now) + "-" + std::to_string(count++));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  // A stream of the standard library keeps others from replacing the file on Windows.
  static std::string content(const fs::path& file) {
    std::string text;
    std::FILE* const in = platform::open_file(file, "rb");
    if (!in) return {};
    for (int c; (c = std::fgetc(in)) != EOF;) text += char(c);
    std::fclose(in);
    return text;
  }
  std::size_t files() const {
    return std::size_t(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  static void expect_error(const Expected<void>& done, const fs::path& file, const std::string& reason) {
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().message.find(file.string() + ": "), 0u) << done.error().message;
    EXPECT_NE(done.error().message.find(reason), std::string::npos) << done.error().message;
  }
  static std::string message(std::errc reason) { return std::make_error_code(reason).message(); }

  fs::path folder_;
};

TEST_F(AtomicFileTest, AppearsAtCommit) {
  const fs::path target = folder_ / "a.bin";
  for (const std::string before : {"", "old"}) {
    auto file = AtomicFile::create(target);
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_TRUE(file->write(bytes_of("new ")));
    EXPECT_TRUE(file->write({}));
    EXPECT_TRUE(file->write(bytes_of("content")));
    EXPECT_EQ(content(target), before);
    ASSERT_TRUE(file->commit());
    EXPECT_EQ(content(target), "new content");
    EXPECT_EQ(files(), 1u);
    std::ofstream(target, std::ios::binary) << "old";
  }
}

TEST_F(AtomicFileTest, WithoutCommitNothingChanges) {
  const fs::path target = folder_ / "a.bin";
  std::ofstream(target) << "old";
  {
    auto file = AtomicFile::create(target);
    ASSERT_TRUE(file);
    EXPECT_TRUE(file->write(bytes_of("new")));
    const AtomicFile moved = std::move(*file);
    EXPECT_EQ(files(), 2u);
  }
  EXPECT_EQ(content(target), "old");
  EXPECT_EQ(files(), 1u);
}

TEST_F(AtomicFileTest, WritesItsPartsInTurn) {
  const std::string large(3'000'000, 'x');
  ASSERT_TRUE(write_file(folder_ / "a.bin", {bytes_of("a"), {}, bytes_of(large), bytes_of("b")}));
  EXPECT_EQ(content(folder_ / "a.bin"), "a" + large + "b");
  ASSERT_TRUE(write_file(folder_ / "a.bin", {}));
  EXPECT_EQ(content(folder_ / "a.bin"), "");
}

TEST_F(AtomicFileTest, ErrorsNameTheFileAndTheReason) {
  const fs::path missing = folder_ / "missing" / "a.bin", below = folder_ / "file" / "a.bin";
  std::ofstream(folder_ / "file") << "old";
  expect_error(write_file(missing, {}), missing, message(std::errc::no_such_file_or_directory));
  expect_error(write_file(below, {}), below,
               message(kPosix ? std::errc::not_a_directory : std::errc::no_such_file_or_directory));
  expect_error(write_file(folder_, {}), folder_, message(std::errc::is_a_directory));
  EXPECT_FALSE(write_file({}, {}));
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(content(folder_ / "file"), "old");
}

/// The target may become a directory in between.
TEST_F(AtomicFileTest, FailsWhereTheTargetCannotBeReplaced) {
  const fs::path target = folder_ / "a.bin";
  auto file = AtomicFile::create(target);
  ASSERT_TRUE(file);
  fs::create_directory(target);
  std::ofstream(target / "b") << "kept";
  const Expected<void> done = file->commit();
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().message.find(target.string() + ": "), 0u);
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(content(target / "b"), "kept");
}

#ifdef SIGHTLINE_HAS_FULL_DISK
/// As on a full disk: writes fail after so many bytes.
TEST_F(AtomicFileTest, AFullDiskLeavesTheOldFile) {
  const fs::path target = folder_ / "a.bin";
  std::ofstream(target) << "old";
  std::optional<tests::FullDisk> full(2'000);
  const std::string little(3'000, 'x'), much(5'000'000, 'x');
  // What fits into the buffer fails at commit(), more fails before.
  const Expected<void> late = write_file(target, {bytes_of(little)});
  auto file = AtomicFile::create(target);
  const bool written = file && file->write(bytes_of(much)), more = file && file->write(bytes_of("x"));
  const bool failed = file && file->failed();
  const Expected<void> early = file ? file->commit() : Expected<void>();
  full.reset();
  expect_error(late, target, message(std::errc::file_too_large));
  expect_error(early, target, message(std::errc::file_too_large));
  EXPECT_FALSE(written);
  EXPECT_FALSE(more);
  EXPECT_TRUE(failed);
  EXPECT_EQ(content(target), "old");
  EXPECT_EQ(files(), 1u);
}
#endif

TEST_F(AtomicFileTest, DevicesAreWrittenToDirectly) {
  if (!fs::is_character_file("/dev/full")) GTEST_SKIP() << "no /dev/full";
  expect_error(write_file("/dev/full", {bytes_of("x")}), "/dev/full", message(std::errc::no_space_on_device));
  EXPECT_TRUE(write_file("/dev/null", {bytes_of("x")}));
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(AtomicFileTest, KeepsPermissionsAndLinks) {
  const fs::path real = folder_ / "real.bin", link = folder_ / "link.bin";
  std::ofstream(real) << "old";
  fs::permissions(real, fs::perms::owner_read | fs::perms::owner_write);
  const fs::perms kept = fs::status(real).permissions();
  const bool linked = tests::make_link("real.bin", link);
  const fs::path target = linked ? link : real;
  ASSERT_TRUE(write_file(target, {bytes_of("new")}));
  EXPECT_EQ(fs::is_symlink(link), linked);
  EXPECT_FALSE(fs::is_symlink(real));
  EXPECT_EQ(content(real), "new");
  EXPECT_EQ(fs::status(real).permissions(), kept);
}

TEST_F(AtomicFileTest, WritersOfOneTargetDoNotMix) {
  const fs::path target = folder_ / "a.bin";
  constexpr std::size_t kBytes = 100'000;
  ASSERT_TRUE(write_file(target, {bytes_of(std::string(kBytes, 'z'))}));
  std::atomic<int> writing{3};
  std::atomic<bool> failed{false};
  std::vector<std::thread> writers;
  for (char letter = 'a'; letter < 'd'; ++letter)
    writers.emplace_back([&, letter] {
      const std::string text(kBytes, letter);
      const auto half = bytes_of(text).first(kBytes / 2);
      for (int i = 0; i < 100; ++i)
        if (!write_file(target, {half, half})) failed = true;
      --writing;
    });
  std::size_t read = 0, torn = 0;
  while (writing > 0) {
    const std::string text = content(target);
    if (!kPosix && text.empty()) continue;  // for a moment there may be no file of the name
    ++read;
    torn += text.size() != kBytes || text.find_first_not_of(text[0]) != std::string::npos;
  }
  for (std::thread& writer : writers) writer.join();
  EXPECT_FALSE(failed);
  EXPECT_EQ(torn, 0u) << "of " << read;
  EXPECT_EQ(files(), 1u);
}

}  // namespace
}  // namespace sightline::core::atomic_file_test
