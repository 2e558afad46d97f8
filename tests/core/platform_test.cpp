// What the operating system offers, by names in any script: files, memory, processes, modules.
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "sightline/core/internal/platform/clock.h"
#include "sightline/core/internal/platform/encoding.h"
#include "sightline/core/internal/platform/environment.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/core/internal/platform/memory.h"
#include "sightline/core/internal/platform/modules.h"
#include "sightline/core/internal/platform/process.h"
#include "sightline/tests/support/places.h"

namespace sightline::core::platform::platform_test {
namespace {

namespace fs = std::filesystem;
using Heard = ChildProcess::Heard;

// "Größe_模型_🏭.slc": two, three and four bytes of UTF-8, the last two units of UTF-16.
const std::string kName = "Gr\u00f6\u00dfe_\u6a21\u578b_\U0001f3ed.slc";

class PlatformFiles : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_FALSE(folder_.empty()); }
  void TearDown() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
    EXPECT_FALSE(fs::exists(folder_));
  }
  static void write(const fs::path& file, std::string_view text) {
    std::FILE* const out = open_file(file, "wb");
    ASSERT_NE(out, nullptr);
    EXPECT_EQ(std::fwrite(text.data(), 1, text.size(), out), text.size());
    EXPECT_EQ(std::fclose(out), 0);
  }
  static std::string content(const fs::path& file) {
    std::FILE* const in = open_file(file, "rb");
    if (!in) return "(cannot be opened)";
    std::string text(1000, '\0');
    text.resize(std::fread(text.data(), 1, text.size(), in));
    std::fclose(in);
    return text;
  }

  fs::path folder_ = make_temporary_folder();
};

TEST_F(PlatformFiles, NamesOfAnyScriptSurvive) {
  const fs::path file = folder_ / path_of(kName);
  EXPECT_EQ(name_of(file.filename()), kName);
  write(file, "one\r\ntwo\n\x1athree");
  EXPECT_EQ(content(file), "one\r\ntwo\n\x1athree");
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(name_of(entry.path().filename()));
  EXPECT_EQ(names, std::vector{kName});
  std::ifstream stream(file, std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(stream), {}), "one\r\ntwo\n\x1athree");
}

TEST_F(PlatformFiles, NoNameFails) {
  for (const std::string name : {"", "\xff\xfe", "\xe6\xa8", "a\xc3", "\xed\xa0\x80"}) {
    const fs::path path = path_of(name);
    EXPECT_FALSE(fs::exists(folder_ / "missing" / path));
    EXPECT_NO_THROW((void)name_of(path));
  }
}

TEST_F(PlatformFiles, AreCreatedOnce) {
  const fs::path file = folder_ / path_of(kName);
  write(file, "first");
  errno = 0;
  EXPECT_EQ(open_file(file, "wbx"), nullptr);
  EXPECT_EQ(errno, EEXIST);
  EXPECT_EQ(content(file), "first");
  errno = 0;
  EXPECT_EQ(open_file(folder_ / "missing", "rb"), nullptr);
  EXPECT_EQ(errno, ENOENT);
  EXPECT_EQ(open_file(folder_ / "no folder" / "file", "wb"), nullptr);
  EXPECT_EQ(errno, ENOENT);
}

TEST_F(PlatformFiles, AreReplacedWhileTheyAreRead) {
  const fs::path file = folder_ / path_of(kName), next = folder_ / "next";
  write(file, "old");
  write(next, "newer");
  const auto open = ReadableFile::open(file);
  ASSERT_TRUE(open);
  std::error_code error = std::make_error_code(std::errc::io_error);
  replace_file(next, file, error);
  EXPECT_FALSE(error) << error.message();
  EXPECT_FALSE(fs::exists(next));
  EXPECT_EQ(content(file), "newer");
  std::array<std::byte, 3> bytes{};
  EXPECT_EQ(open->read(0, bytes).value_or(0), 3u);
  EXPECT_EQ(std::memcmp(bytes.data(), "old", 3), 0);
  replace_file(folder_ / "missing", file, error);
  EXPECT_EQ(error, std::errc::no_such_file_or_directory) << error.message();
}

TEST_F(PlatformFiles, AreReadFromAnyPlace) {
  const fs::path file = folder_ / path_of(kName);
  write(file, "0123456789");
  const auto open = ReadableFile::open(file);
  ASSERT_TRUE(open);
  EXPECT_TRUE(open->is_regular());
  EXPECT_EQ(open->size(), 10u);
  std::array<std::byte, 8> bytes{};
  EXPECT_EQ(open->read(1, bytes).value_or(0), 8u);
  EXPECT_EQ(std::memcmp(bytes.data(), "12345678", 8), 0);
  EXPECT_EQ(open->read(6, bytes).value_or(0), 4u) << "more was asked for than the file has";
  EXPECT_EQ(std::memcmp(bytes.data(), "6789", 4), 0);
  EXPECT_EQ(open->read(10, bytes).value_or(1), 0u);
  EXPECT_EQ(open->read(std::uint64_t(1) << 40, bytes).value_or(1), 0u);
}

TEST_F(PlatformFiles, MissingAndOtherThanRegularOnesAreTold) {
  const auto missing = ReadableFile::open(folder_ / path_of(kName));
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error(), std::errc::no_such_file_or_directory) << missing.error().message();
  const auto folder = ReadableFile::open(folder_);
  EXPECT_TRUE(!folder || !folder->is_regular());
}

TEST_F(PlatformFiles, AreMapped) {
  const fs::path file = folder_ / path_of(kName);
  const std::size_t size = 3 * page_size() + 5;
  std::string text(size, 'a');
  text.back() = 'z';
  write(file, text);
  std::shared_ptr<std::byte> written, read;
  {
    const auto open = ReadableFile::open(file);
    ASSERT_TRUE(open);
    written = open->map(ReadableFile::Access::kWriteCopy).value_or(nullptr);
    read = open->map(ReadableFile::Access::kRead).value_or(nullptr);
  }
  ASSERT_TRUE(written && read) << "mappings outlive what made them";
  EXPECT_EQ(std::memcmp(read.get(), text.data(), size), 0);
  std::memset(written.get(), 'b', size);
  EXPECT_EQ(std::memcmp(read.get(), text.data(), size), 0) << "written to the file";
  set_aside(read.get(), 1, size);
  EXPECT_EQ(std::memcmp(read.get(), text.data(), size), 0) << "lost";
  EXPECT_EQ(fs::file_size(file), size);
}

TEST_F(PlatformFiles, EmptyOnesHaveNoMapping) {
  const fs::path file = folder_ / path_of(kName);
  write(file, "");
  const auto open = ReadableFile::open(file);
  ASSERT_TRUE(open);
  EXPECT_TRUE(open->is_regular());
  EXPECT_EQ(open->size(), 0u);
  std::array<std::byte, 8> bytes{};
  EXPECT_EQ(open->read(0, bytes).value_or(1), 0u);
  const auto mapping = open->map(ReadableFile::Access::kRead);
  ASSERT_TRUE(mapping);
  EXPECT_EQ(*mapping, nullptr);
}

TEST_F(PlatformFiles, TemporaryFoldersDiffer) {
  const fs::path other = make_temporary_folder();
  EXPECT_NE(other, folder_);
  EXPECT_TRUE(fs::is_empty(other));
  fs::remove(other);
}

TEST(PlatformMemory, PagesAreZeroAndTakenOnTouch) {
  const std::size_t page = page_size();
  ASSERT_GE(page, 4096u);
  ASSERT_EQ(page & (page - 1), 0u);
  const std::size_t size = 64 << 20, before = process_memory();
  auto* const memory = static_cast<unsigned char*>(reserve_pages(size));
  ASSERT_NE(memory, nullptr);
  EXPECT_EQ(std::uintptr_t(memory) % page, 0u);
  for (std::size_t i = 0; i < size; i += page) memory[i] += 1;
  if (before > 0) {
    EXPECT_GT(process_memory(), before + size / 2);
    EXPECT_GE(peak_memory(), before + size / 2);
  }
  EXPECT_GT(physical_memory(), size);
  release_pages(memory, size);
  give_back_free_memory();
}

TEST(PlatformMemory, WhatNoMachineHasIsRefused) {
  EXPECT_EQ(reserve_pages(std::size_t(1) << 62), nullptr);
}

TEST(PlatformMemory, HugePagesMove) {
  if constexpr (kHasHugePages) {
    auto* const small = static_cast<unsigned char*>(reserve_huge_pages(kHugePage));
    auto* const large = static_cast<unsigned char*>(reserve_huge_pages(4 * kHugePage));
    ASSERT_TRUE(small && large);
    EXPECT_EQ(std::uintptr_t(large) % kHugePage, 0u);
    std::memset(small, 7, kHugePage);
    ASSERT_TRUE(move_huge_pages(small, kHugePage, large, 4 * kHugePage));
    EXPECT_EQ(large[0], 7);
    EXPECT_EQ(large[kHugePage - 1], 7);
    large[4 * kHugePage - 1] = 1;
    prefer_small_pages(large + 2 * kHugePage, 2 * kHugePage);
    EXPECT_EQ(large[4 * kHugePage - 1], 1);
    release_pages(large, 4 * kHugePage);
  } else {
    GTEST_SKIP() << "this system has none";
  }
}

TEST(PlatformEnvironment, HoldsAnyText) {
  EXPECT_EQ(environment("SIGHTLINE_PLATFORM_TEST"), std::nullopt);
  set_environment("SIGHTLINE_PLATFORM_TEST", kName);
  EXPECT_EQ(environment("SIGHTLINE_PLATFORM_TEST"), kName);
  set_environment("SIGHTLINE_PLATFORM_TEST", std::nullopt);
  EXPECT_EQ(environment("SIGHTLINE_PLATFORM_TEST"), std::nullopt);
}

TEST(PlatformEnvironment, FoldersAreAbsoluteOrNone) {
  const auto before = environment("XDG_CACHE_HOME");
  const fs::path here = fs::current_path() / path_of(kName);
  set_environment("XDG_CACHE_HOME", name_of(here));
  EXPECT_EQ(cache_folder(), here);
  set_environment("XDG_CACHE_HOME", "relative");
  EXPECT_TRUE(cache_folder().empty() || cache_folder().is_absolute());
  EXPECT_TRUE(settings_folder().empty() || settings_folder().is_absolute());
  EXPECT_TRUE(home_folder().empty() || home_folder().is_absolute());
  set_environment("XDG_CACHE_HOME", before);
}

TEST(PlatformEncoding, ReadsWhatOtherSystemsWrite) {
  EXPECT_EQ(decoded("Gr\xf6\xdf\x65", "ISO-8859-1"), "Gr\u00f6\u00dfe");
  EXPECT_EQ(decoded("Gr\xf6\xdf\x65", "Latin-1"), "Gr\u00f6\u00dfe");
  EXPECT_EQ(decoded("\xc3\xf0\xee", "windows-1251"), "\u0413\u0440\u043e");
  EXPECT_EQ(decoded("\x96\xcd", "Shift_JIS"), "\u6a21");
  EXPECT_EQ(decoded("", "ISO-8859-1"), "");
  EXPECT_EQ(decoded("x", "no such encoding"), std::nullopt);
  EXPECT_EQ(decoded("x\xff", "UTF-8"), std::nullopt);
}

TEST(PlatformClock, KnowsTheCalendar) {
  std::tm utc{};
  ASSERT_TRUE(utc_of(951827696, utc));
  EXPECT_EQ(utc.tm_year, 100);
  EXPECT_EQ(utc.tm_mon, 1);
  EXPECT_EQ(utc.tm_mday, 29);
  EXPECT_EQ(utc.tm_hour, 12);
}

TEST(PlatformMath, FusedProductsAreRoundedOnce) {
  volatile double a = 1.0 + 0x1p-30, b = 1.0 - 0x1p-30, c = -1.0, tiny = 0x1p-105;
  EXPECT_EQ(std::fma(a, b, c), -0x1p-60);
  // Half a unit and a trace of more: a first rounding to 64 bits would lose the trace.
  volatile double x = 1.0 + 0x1p-52, half = 0x1p-53;
  EXPECT_EQ(std::fma(half, 1.0 + tiny * 0x1p53, x), 1.0 + 0x1p-51);
  volatile float f = 1.0f + 0x1p-12f, g = 1.0f - 0x1p-12f, h = -1.0f;
  EXPECT_EQ(std::fma(f, g, h), -0x1p-24f);
}

// --- processes -------------------------------------------------------------------------------------------------------

/// The program that starts this one: itself, or, where an emulator runs it, a script among the tools that leads there.
fs::path starter() {
  const fs::path script = tests::in_bin(program_file().filename().string());
  return fs::exists(script) ? script : program_file();
}

/// This program once more, with the case below that does as the variable says.
class PlatformProcess : public ::testing::Test {
 protected:
  static Expected<ChildProcess> start(const std::string& what, const ChildProcess::Options& options) {
    set_environment("SIGHTLINE_PLATFORM_CHILD", what);
    auto made =
        ChildProcess::start({name_of(starter()), "--gtest_filter=PlatformChild.*", "a b", "c\"d\\", ""}, options);
    set_environment("SIGHTLINE_PLATFORM_CHILD", std::nullopt);
    return made;
  }
  /// All that it answers.
  static std::string listen(ChildProcess& child) {
    std::string heard;
    const ChildProcess* const one = &child;
    for (;;) {
      ChildProcess::wait_for_answers({&one, 1}, std::chrono::milliseconds(100));
      if (child.read(heard) == Heard::kEnd) return heard;
    }
  }
};

TEST(PlatformChild, DoesAsItsParentSays) {
  const std::string what = environment("SIGHTLINE_PLATFORM_CHILD").value_or("");
  if (what.empty()) GTEST_SKIP() << "is for the other cases";
  set_environment("SIGHTLINE_PLATFORM_CHILD", std::nullopt);
  const auto parent = AnswerPipe::of_this_process();
  if (!parent) end_at_once(9);
  if (what == "answer") parent->write("said: " + kName + "\n" + std::string(100000, 'x'));
  if (what == "echo") {
    std::string line(64, '\0');
    while (std::fgets(line.data(), int(line.size()), stdin))
      if (!parent->write("got " + std::string(line.c_str()))) end_at_once(8);
  }
  if (what == "crash") {
    write_no_core_dumps();
    std::signal(SIGSEGV, SIG_DFL);  // sanitizers would tell of the fault and return a code
    volatile std::uintptr_t nowhere = 64;
    *reinterpret_cast<volatile int*>(nowhere) = 1;
  }
  while (what == "stay") parent->write("");
  end_at_once(what == "answer" ? 3 : 0);
}

TEST_F(PlatformProcess, AnswersAndReturnsACode) {
  auto child = start("answer", {});
  ASSERT_TRUE(child) << child.error().message;
  EXPECT_TRUE(child->is_running());
  EXPECT_EQ(listen(*child), "said: " + kName + "\n" + std::string(100000, 'x'));
  const ProcessEnd end = child->wait();
  EXPECT_EQ(end.kind, ProcessEnd::Kind::kExited);
  EXPECT_EQ(end.code, 3);
  EXPECT_FALSE(child->is_running());
}

TEST_F(PlatformProcess, ReadsWhatItIsTold) {
  survive_broken_pipes();
  auto child = start("echo", {.reads = true, .may_print = true});
  ASSERT_TRUE(child) << child.error().message;
  std::string heard;
  const ChildProcess* const one = &*child;
  EXPECT_TRUE(child->write("one\n"));
  while (heard != "got one\n") {
    ChildProcess::wait_for_answers({&one, 1}, std::chrono::milliseconds(100));
    ASSERT_NE(child->read(heard), Heard::kEnd) << heard;
  }
  EXPECT_EQ(child->read(heard), Heard::kNothing);
  EXPECT_TRUE(child->write("two\n"));
  while (heard != "got one\ngot two\n") {
    ChildProcess::wait_for_answers({&one, 1}, std::chrono::milliseconds(100));
    ASSERT_NE(child->read(heard), Heard::kEnd) << heard;
  }
  const ProcessEnd end = child->wait();  // its input ends
  EXPECT_EQ(end.kind, ProcessEnd::Kind::kExited);
  EXPECT_EQ(end.code, 0);
}

TEST_F(PlatformProcess, ACrashIsNoCode) {
  auto child = start("crash", {});
  ASSERT_TRUE(child) << child.error().message;
  EXPECT_EQ(listen(*child), "");
  const ProcessEnd end = child->wait();
  EXPECT_EQ(end.kind, ProcessEnd::Kind::kCrashed) << end.code;
  EXPECT_FALSE(end.reason.empty());
  EXPECT_FALSE(end.name.empty());
}

TEST_F(PlatformProcess, IsKilled) {
  survive_broken_pipes();
  auto child = start("stay", {.reads = true});
  ASSERT_TRUE(child) << child.error().message;
  child->kill();
  EXPECT_EQ(listen(*child), "");
  while (child->write("nobody reads\n")) {  // the system may close its pipes in any order
  }
  const ProcessEnd end = child->wait();
  EXPECT_EQ(end.kind, ProcessEnd::Kind::kCrashed);
  EXPECT_EQ(end.name, "Killed");
}

TEST_F(PlatformProcess, GoesWithWhatHoldsIt) {
  auto child = start("stay", {});
  ASSERT_TRUE(child) << child.error().message;
  *child = ChildProcess();  // returns, though that process would never end
  EXPECT_FALSE(child->is_running());
}

TEST(PlatformPrograms, AMissingOneIsTold) {
  if (starter() != program_file()) GTEST_SKIP() << "qemu's vfork() is a fork(), which reports no failure";
  const auto child = ChildProcess::start({name_of(fs::current_path() / path_of("no " + kName))}, {});
  ASSERT_FALSE(child);
  EXPECT_FALSE(child.error().message.empty());
}

TEST(PlatformPrograms, AreFiles) {
  EXPECT_TRUE(fs::is_regular_file(program_file())) << program_file();
  EXPECT_TRUE(fs::is_regular_file(program_image()));
  const fs::path module = module_of(reinterpret_cast<const void*>(&program_file));
  EXPECT_TRUE(fs::equivalent(module, program_file()) || fs::equivalent(module, starter())) << module;
}

TEST(PlatformModules, AMissingOneIsTold) {
  for (const std::string name : {"no_such_library", kName.c_str()}) {
    const auto module = open_module(path_of(name));
    ASSERT_FALSE(module);
    EXPECT_FALSE(module.error().message.empty());
  }
}

TEST(PlatformModules, HaveSymbols) {
  const auto module = open_module("libc.so.6").or_else([](const Error&) { return open_module("kernel32.dll"); });
  ASSERT_TRUE(module) << module.error().message;
  EXPECT_EQ(find_in_module(*module, "sightline_no_such_symbol"), nullptr);
  EXPECT_FALSE(symbol_error().empty());
  const bool found = find_in_module(*module, "getenv") || find_in_module(*module, "GetEnvironmentVariableW");
  EXPECT_TRUE(found);
}

}  // namespace
}  // namespace sightline::core::platform::platform_test
