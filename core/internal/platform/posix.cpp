#include <array>
#include <cerrno>
#include <cstdlib>
#include <utility>

#include <fcntl.h>
#include <iconv.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

#include "sightline/core/internal/platform/clock.h"
#include "sightline/core/internal/platform/console.h"
#include "sightline/core/internal/platform/encoding.h"
#include "sightline/core/internal/platform/environment.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/core/internal/platform/memory.h"
#include "sightline/core/internal/platform/threads.h"

namespace sightline::core::platform {
namespace {

namespace fs = std::filesystem;

std::error_code last_error() {
  return {errno, std::generic_category()};
}

/// The first of the variables that holds an absolute path, and what lies below it.
fs::path first_folder(std::initializer_list<std::pair<const char*, const char*>> places) {
  for (const auto& [variable, below] : places) {
    const char* value = std::getenv(variable);
    if (value && fs::path(value).is_absolute()) return *below ? fs::path(value) / below : fs::path(value);
  }
  return {};
}

}  // namespace

// --- files -----------------------------------------------------------------------------------------------------------

fs::path path_of(std::string_view name) {
  return name;
}

std::string name_of(const fs::path& path) {
  return path.string();
}

std::FILE* open_file(const fs::path& path, const char* mode) {
  return std::fopen(path.c_str(), mode);
}

std::int64_t write_time(const fs::path& path, std::error_code& error) {
  const auto time = fs::last_write_time(path, error);
  return error ? 0 : std::int64_t(time.time_since_epoch().count());
}

void replace_file(const fs::path& from, const fs::path& to, std::error_code& error) {
  fs::rename(from, to, error);
}

void set_temporary_folder(const fs::path& folder) {
  setenv("TMPDIR", folder.c_str(), 1);
}

fs::path make_temporary_folder() {
  std::error_code failed;
  std::string pattern = (fs::temp_directory_path(failed) / "sightline-XXXXXX").string();
  return !failed && mkdtemp(pattern.data()) ? fs::path(pattern) : fs::path();
}

fs::path cache_folder() {
  return first_folder({{"XDG_CACHE_HOME", ""}, {"HOME", ".cache"}});
}

fs::path settings_folder() {
  return first_folder({{"XDG_CONFIG_HOME", ""}, {"HOME", ".config"}});
}

fs::path home_folder() {
  return first_folder({{"HOME", ""}});
}

tl::expected<ReadableFile, std::error_code> ReadableFile::open(const fs::path& path) {
  ReadableFile file;
  file.handle_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  struct stat status {};
  if (file.handle_ == kClosed || fstat(int(file.handle_), &status) != 0) return tl::unexpected(last_error());
  file.regular_ = S_ISREG(status.st_mode);
  file.size_ = std::uint64_t(status.st_size);
  return file;
}

ReadableFile::~ReadableFile() {
  if (is_open()) close(int(handle_));
}

tl::expected<std::size_t, std::error_code> ReadableFile::read(std::uint64_t offset, std::span<std::byte> to) const {
  std::size_t all = 0;
  while (all < to.size()) {
    const ssize_t got = pread(int(handle_), to.data() + all, to.size() - all, off_t(offset + all));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return tl::unexpected(last_error());
    if (got == 0) break;
    all += std::size_t(got);
  }
  return all;
}

tl::expected<std::shared_ptr<std::byte>, std::error_code> ReadableFile::map(Access access) const {
  if (size_ == 0) return std::shared_ptr<std::byte>();
  const int protection = access == Access::kRead ? PROT_READ : PROT_READ | PROT_WRITE;
  void* const memory = mmap(nullptr, std::size_t(size_), protection, MAP_PRIVATE, int(handle_), 0);
  if (memory == MAP_FAILED) return tl::unexpected(last_error());
  return std::shared_ptr<std::byte>(static_cast<std::byte*>(memory),
                                    [size = std::size_t(size_)](std::byte* bytes) { munmap(bytes, size); });
}

void set_aside(std::byte* mapping, std::uint64_t begin, std::uint64_t end) {
  const std::uint64_t page = page_size();
  begin = (begin + page - 1) / page * page;
  end = end / page * page;
  if (begin < end) (void)madvise(mapping + begin, std::size_t(end - begin), MADV_DONTNEED);
}

// --- memory ----------------------------------------------------------------------------------------------------------

std::size_t page_size() {
  return std::size_t(sysconf(_SC_PAGESIZE));
}

std::uint64_t physical_memory() {
  const auto pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
  return pages > 0 && size > 0 ? std::uint64_t(pages) * std::uint64_t(size) : 0;
}

std::size_t process_memory() {
  std::FILE* const file = std::fopen("/proc/self/statm", "r");
  if (!file) return 0;
  unsigned long total = 0, resident = 0;
  const int read = std::fscanf(file, "%lu %lu", &total, &resident);
  std::fclose(file);
  return read == 2 ? std::size_t(resident) * page_size() : 0;
}

std::size_t peak_memory() {
  rusage usage{};
  return getrusage(RUSAGE_SELF, &usage) == 0 ? std::size_t(usage.ru_maxrss) * 1024 : 0;
}

void give_back_free_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

void* reserve_pages(std::size_t bytes) {
  void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return memory == MAP_FAILED ? nullptr : memory;
}

void release_pages(void* memory, std::size_t bytes) {
  munmap(memory, bytes);
}

#ifdef __linux__

void* reserve_huge_pages(std::size_t bytes) {
  const std::size_t wide = bytes + kHugePage;
  void* const memory = wide < bytes ? nullptr : reserve_pages(wide);
  if (!memory) return nullptr;
  const std::size_t before = (kHugePage - std::uintptr_t(memory) % kHugePage) % kHugePage;
  auto* const first = static_cast<std::byte*>(memory) + before;
  if (before > 0) munmap(memory, before);
  munmap(first + bytes, kHugePage - before);
  (void)madvise(first, bytes, MADV_HUGEPAGE);  // a refusal changes nothing but speed
  return first;
}

bool move_huge_pages(void* from, std::size_t bytes, void* to, std::size_t to_bytes) {
  return mremap(from, bytes, to_bytes, MREMAP_MAYMOVE | MREMAP_FIXED, to) != MAP_FAILED;
}

void prefer_small_pages(void* memory, std::size_t bytes) {
  (void)madvise(memory, bytes, MADV_NOHUGEPAGE);
}

#endif

// --- threads ---------------------------------------------------------------------------------------------------------

void at_end_of_thread(void (*run)(void* object), void* object) {
  struct Entries {
    ~Entries() {
      for (; !all.empty(); all.pop_back()) all.back().first(all.back().second);
    }
    std::vector<std::pair<void (*)(void*), void*>> all;
  };
  thread_local Entries entries;
  entries.all.emplace_back(run, object);
}

void wait_while(const std::atomic<std::uint32_t>& value, std::uint32_t seen) {
  value.wait(seen);
}
void wake_all(std::atomic<std::uint32_t>& value) {
  value.notify_all();
}

// --- environment, encodings, console, calendar -----------------------------------------------------------------------

std::optional<std::string> environment(const char* name) {
  const char* const value = std::getenv(name);
  return value ? std::optional<std::string>(value) : std::nullopt;
}

void set_environment(const char* name, const std::optional<std::string>& value) {
  value ? setenv(name, value->c_str(), 1) : unsetenv(name);
}

std::optional<std::string> decoded(std::string_view text, std::string_view encoding) {
  std::string name(encoding), joined;  // "Latin-1" is LATIN1 to the system
  for (const char c : encoding)
    if (c != '-' && c != ' ') joined += c;
  const auto none = reinterpret_cast<iconv_t>(-1);
  iconv_t converter = iconv_open("UTF-8", name.c_str());
  if (converter == none) converter = iconv_open("UTF-8", joined.c_str());
  if (converter == none) return {};
  std::string from(text), to(4 * text.size() + 4, '\0');
  char *in = from.data(), *out = to.data();
  std::size_t in_left = from.size(), out_left = to.size();
  const bool good = iconv(converter, &in, &in_left, &out, &out_left) != std::size_t(-1) && in_left == 0;
  iconv_close(converter);
  to.resize(to.size() - out_left);
  return good ? std::optional(std::move(to)) : std::nullopt;
}

std::vector<std::string> begin_program(int argc, char** argv) {
  return {argv, argv + argc};
}

std::string shell_word(const std::string& word) {
  constexpr const char* kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./,:=+-";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

bool errors_are_on_terminal() {
  return isatty(STDERR_FILENO) != 0;
}

bool utc_of(std::time_t time, std::tm& utc) {
  return gmtime_r(&time, &utc) != nullptr;
}

}  // namespace sightline::core::platform
