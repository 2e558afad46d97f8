#include "sightline/core/internal/platform/windows.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <cwchar>
#include <utility>

#include <fcntl.h>
#include <io.h>
#include <malloc.h>
#include <psapi.h>
#include <shellapi.h>

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

// Others may read, replace and delete a file while it is open, as on other systems.
constexpr DWORD kShared = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;

HANDLE handle_of(std::intptr_t value) {
  return reinterpret_cast<HANDLE>(value);
}

/// The first of the variables that holds an absolute path.
fs::path first_folder(std::initializer_list<const char*> variables) {
  for (const char* const variable : variables) {
    const auto value = environment(variable);
    if (value && path_of(*value).is_absolute()) return path_of(*value);
  }
  return {};
}

int errno_of(DWORD error) {
  const std::error_condition portable = std::system_category().default_error_condition(int(error));
  return portable.category() == std::generic_category() ? portable.value() : EIO;
}

/// What a rename says while another process looks at the file, or replaces it at the same time.
bool may_pass(DWORD error) {
  return error == ERROR_ACCESS_DENIED || error == ERROR_SHARING_VIOLATION || error == ERROR_LOCK_VIOLATION;
}

/// A rename that replaces a file which others have open or mapped; since version 1607 of Windows 10, on NTFS. They keep
/// the old content.
bool replace_open_file(const fs::path& from, const fs::path& to) {
  constexpr auto kRenameInfoEx = FILE_INFO_BY_HANDLE_CLASS(22);
  constexpr DWORD kReplaceAsPosix = 0x1 | 0x2;
  const HANDLE file =
      CreateFileW(from.c_str(), DELETE | SYNCHRONIZE, kShared, nullptr, OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, nullptr);
  if (file == INVALID_HANDLE_VALUE) return false;
  std::error_code failed;
  const std::wstring name = fs::absolute(to, failed).make_preferred().native();
  std::vector<unsigned char> memory(sizeof(FILE_RENAME_INFO) + name.size() * sizeof(wchar_t));
  auto* const info = reinterpret_cast<FILE_RENAME_INFO*>(memory.data());
  std::memcpy(memory.data(), &kReplaceAsPosix, sizeof kReplaceAsPosix);
  info->FileNameLength = DWORD(name.size() * sizeof(wchar_t));
  std::memcpy(info->FileName, name.data(), info->FileNameLength);
  const bool done = SetFileInformationByHandle(file, kRenameInfoEx, info, DWORD(memory.size()));
  CloseHandle(file);
  return done;
}

/// Replaces a file where the system cannot do that: readers keep the file under another name, which is then deleted.
/// For a moment there is no file of the name.
bool replace_by_moving_aside(const fs::path& from, const fs::path& to) {
  static std::atomic<std::uint32_t> next = GetTickCount();
  fs::path aside = to;
  aside += L"." + std::to_wstring(next++) + L".part";
  if (!MoveFileExW(to.c_str(), aside.c_str(), 0)) return false;
  const bool done = MoveFileExW(from.c_str(), to.c_str(), 0);
  if (!done) MoveFileExW(aside.c_str(), to.c_str(), 0);
  DeleteFileW(aside.c_str());
  return done;
}

PROCESS_MEMORY_COUNTERS memory_counters() {
  PROCESS_MEMORY_COUNTERS counters{};
  counters.cb = sizeof counters;
  if (!K32GetProcessMemoryInfo(GetCurrentProcess(), &counters, sizeof counters)) return {};
  return counters;
}

SYSTEM_INFO system_info() {
  SYSTEM_INFO info{};
  GetSystemInfo(&info);
  return info;
}

/// The system's number of an encoding. Names are compared by their letters and digits.
std::optional<UINT> code_page_of(std::string_view encoding) {
  std::string name;
  for (const char c : encoding) {
    if (c >= 'a' && c <= 'z') name += char(c - 'a' + 'A');
    if ((c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9')) name += c;
  }
  constexpr std::pair<std::string_view, UINT> kNames[] = {
      {"UTF8", CP_UTF8}, {"ASCII", 20127},  {"USASCII", 20127}, {"LATIN1", 28591},
      {"LATIN2", 28592}, {"SHIFTJIS", 932}, {"SJIS", 932},      {"EUCJP", 20932},
      {"GB2312", 936},   {"GBK", 936},      {"GB18030", 54936}, {"BIG5", 950},
      {"EUCKR", 949},    {"KOI8R", 20866},  {"KOI8U", 21866},   {"MACINTOSH", 10000}};
  for (const auto& [known, page] : kNames)
    if (name == known) return page;
  // Families whose last digits are those of the system's numbers.
  constexpr std::pair<std::string_view, UINT> kFamilies[] = {{"ISO8859", 28590}, {"WINDOWS", 0}, {"CP", 0}, {"IBM", 0}};
  for (const auto& [family, first] : kFamilies) {
    if (!name.starts_with(family) || name.size() == family.size()) continue;
    UINT number = 0;
    const char* const end = name.data() + name.size();
    if (std::from_chars(name.data() + family.size(), end, number).ptr == end) return first + number;
  }
  return std::nullopt;
}

}  // namespace

// --- text ------------------------------------------------------------------------------------------------------------

std::wstring wide_of(std::string_view text) {
  const int size = MultiByteToWideChar(CP_UTF8, 0, text.data(), int(text.size()), nullptr, 0);
  std::wstring wide(std::size_t(size), L'\0');
  MultiByteToWideChar(CP_UTF8, 0, text.data(), int(text.size()), wide.data(), size);
  return wide;
}

std::string utf8_of(std::wstring_view text) {
  const int size = WideCharToMultiByte(CP_UTF8, 0, text.data(), int(text.size()), nullptr, 0, nullptr, nullptr);
  std::string utf8(std::size_t(size), '\0');
  WideCharToMultiByte(CP_UTF8, 0, text.data(), int(text.size()), utf8.data(), size, nullptr, nullptr);
  return utf8;
}

std::string words_of(const std::error_code& error) {
  std::string words = error.message();
  while (!words.empty() && (words.back() == '\n' || words.back() == '\r' || words.back() == ' ')) words.pop_back();
  return words;
}

// --- files -----------------------------------------------------------------------------------------------------------

fs::path path_of(std::string_view name) {
  return wide_of(name);
}

std::string name_of(const fs::path& path) {
  return utf8_of(path.native());
}

std::FILE* open_file(const fs::path& path, const char* mode) {
  const std::string_view how = mode;
  const bool reads = how.starts_with('r'), fresh = how.find('x') != how.npos;
  const HANDLE handle = CreateFileW(path.c_str(), reads ? GENERIC_READ : GENERIC_WRITE, kShared, nullptr,
                                    reads   ? OPEN_EXISTING
                                    : fresh ? CREATE_NEW
                                            : CREATE_ALWAYS,
                                    FILE_ATTRIBUTE_NORMAL, nullptr);
  if (handle == INVALID_HANDLE_VALUE) {
    errno = errno_of(GetLastError());
    return nullptr;
  }
  const int descriptor = _open_osfhandle(std::intptr_t(handle), reads ? _O_RDONLY | _O_BINARY : _O_BINARY);
  if (descriptor < 0) {
    CloseHandle(handle);
    return nullptr;
  }
  std::FILE* const file = _fdopen(descriptor, reads ? "rb" : "wb");
  if (!file) _close(descriptor);
  return file;
}

std::int64_t write_time(const fs::path& path, std::error_code& error) {
  // The standard library of g++ counts whole seconds here.
  WIN32_FILE_ATTRIBUTE_DATA data{};
  error.clear();
  if (GetFileAttributesExW(path.c_str(), GetFileExInfoStandard, &data))
    return std::int64_t(std::uint64_t(data.ftLastWriteTime.dwHighDateTime) << 32 | data.ftLastWriteTime.dwLowDateTime);
  error = last_error();
  return 0;
}

void replace_file(const fs::path& from, const fs::path& to, std::error_code& error) {
  constexpr int kTries = 200;
  constexpr DWORD kMilliseconds = 5;
  std::error_code ignored;
  for (int i = 0; i < kTries; ++i) {
    error.clear();
    if (replace_open_file(from, to)) return;
    if (MoveFileExW(from.c_str(), to.c_str(), MOVEFILE_REPLACE_EXISTING)) return;
    error = last_error();
    if (!may_pass(DWORD(error.value())) || fs::is_directory(to, ignored)) return;
    if (replace_by_moving_aside(from, to)) return error.clear();
    Sleep(kMilliseconds);
  }
}

void set_temporary_folder(const fs::path& folder) {
  set_environment("TMP", name_of(folder));
}

fs::path make_temporary_folder() {
  std::error_code failed;
  const fs::path parent = fs::temp_directory_path(failed);
  if (failed) return {};
  LARGE_INTEGER now{};
  QueryPerformanceCounter(&now);
  constexpr int kTries = 1000;
  // Only the user may look into his folder of temporary files.
  for (int i = 0; i < kTries; ++i) {
    const auto number = std::uint64_t(now.QuadPart) + std::uint64_t(i) * 7919;
    const fs::path folder =
        parent / path_of("sightline-" + std::to_string(GetCurrentProcessId()) + "-" + std::to_string(number));
    if (CreateDirectoryW(folder.c_str(), nullptr)) return folder;
    if (GetLastError() != ERROR_ALREADY_EXISTS) return {};
  }
  return {};
}

fs::path cache_folder() {
  return first_folder({"XDG_CACHE_HOME", "LOCALAPPDATA"});
}

fs::path settings_folder() {
  return first_folder({"XDG_CONFIG_HOME", "APPDATA"});
}

fs::path home_folder() {
  return first_folder({"USERPROFILE", "HOME"});
}

tl::expected<ReadableFile, std::error_code> ReadableFile::open(const fs::path& path) {
  // That folders can be opened needs the flag; what they are is asked then.
  const HANDLE handle = CreateFileW(path.c_str(), GENERIC_READ, kShared, nullptr, OPEN_EXISTING,
                                    FILE_ATTRIBUTE_NORMAL | FILE_FLAG_BACKUP_SEMANTICS, nullptr);
  if (handle == INVALID_HANDLE_VALUE) return tl::unexpected(last_error());
  ReadableFile file;
  file.handle_ = std::intptr_t(handle);
  BY_HANDLE_FILE_INFORMATION info{};
  const bool known = GetFileType(handle) == FILE_TYPE_DISK && GetFileInformationByHandle(handle, &info);
  file.regular_ = known && !(info.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY);
  file.size_ = std::uint64_t(info.nFileSizeHigh) << 32 | info.nFileSizeLow;
  return file;
}

ReadableFile::~ReadableFile() {
  if (is_open()) CloseHandle(handle_of(handle_));
}

tl::expected<std::size_t, std::error_code> ReadableFile::read(std::uint64_t offset, std::span<std::byte> to) const {
  constexpr std::size_t kMost = std::size_t(1) << 30;  // one call counts in 32 bits
  std::size_t all = 0;
  while (all < to.size()) {
    OVERLAPPED place{};
    place.Offset = DWORD(offset + all);
    place.OffsetHigh = DWORD((offset + all) >> 32);
    DWORD got = 0;
    if (!ReadFile(handle_of(handle_), to.data() + all, DWORD(std::min(kMost, to.size() - all)), &got, &place)) {
      if (GetLastError() == ERROR_HANDLE_EOF) break;
      return tl::unexpected(last_error());
    }
    if (got == 0) break;
    all += got;
  }
  return all;
}

tl::expected<std::shared_ptr<std::byte>, std::error_code> ReadableFile::map(Access access) const {
  if (size_ == 0) return std::shared_ptr<std::byte>();
  const bool read = access == Access::kRead;
  const HANDLE section =
      CreateFileMappingW(handle_of(handle_), nullptr, read ? PAGE_READONLY : PAGE_WRITECOPY, 0, 0, nullptr);
  if (!section) return tl::unexpected(last_error());
  void* const memory = MapViewOfFile(section, read ? FILE_MAP_READ : FILE_MAP_COPY, 0, 0, std::size_t(size_));
  const std::error_code error = last_error();
  CloseHandle(section);
  if (!memory) return tl::unexpected(error);
  return std::shared_ptr<std::byte>(static_cast<std::byte*>(memory), [](std::byte* bytes) { UnmapViewOfFile(bytes); });
}

void set_aside(std::byte* mapping, std::uint64_t begin, std::uint64_t end) {
  const std::uint64_t page = page_size();
  begin = (begin + page - 1) / page * page;
  end = end / page * page;
  // Unlocking pages that are not locked takes them out of the working set.
  if (begin < end) (void)VirtualUnlock(mapping + begin, std::size_t(end - begin));
}

// --- memory ----------------------------------------------------------------------------------------------------------

std::size_t page_size() {
  static const std::size_t size = system_info().dwPageSize;
  return size;
}

std::uint64_t physical_memory() {
  MEMORYSTATUSEX status{};
  status.dwLength = sizeof status;
  return GlobalMemoryStatusEx(&status) ? status.ullTotalPhys : 0;
}

std::size_t process_memory() {
  return memory_counters().WorkingSetSize;
}

std::size_t peak_memory() {
  return memory_counters().PeakWorkingSetSize;
}

void give_back_free_memory() {
  _heapmin();
}

void* reserve_pages(std::size_t bytes) {
  return VirtualAlloc(nullptr, bytes, MEM_RESERVE | MEM_COMMIT, PAGE_READWRITE);
}

void release_pages(void* memory, std::size_t) {
  VirtualFree(memory, 0, MEM_RELEASE);
}

// --- threads ---------------------------------------------------------------------------------------------------------

void at_end_of_thread(void (*run)(void* object), void* object) {
  struct Entry {
    void (*run)(void*);
    void* object;
    Entry* before;
  };
  static const DWORD place = FlsAlloc([](void* first) {
    for (auto* entry = static_cast<Entry*>(first); entry;) {
      Entry* const before = entry->before;
      entry->run(entry->object);
      delete std::exchange(entry, before);
    }
  });
  FlsSetValue(place, new Entry{run, object, static_cast<Entry*>(FlsGetValue(place))});
}

static_assert(sizeof(std::atomic<std::uint32_t>) == sizeof(std::uint32_t));
void wait_while(const std::atomic<std::uint32_t>& value, std::uint32_t seen) {
  WaitOnAddress(const_cast<std::atomic<std::uint32_t>*>(&value), &seen, sizeof seen, INFINITE);
}
void wake_all(std::atomic<std::uint32_t>& value) {
  WakeByAddressAll(&value);
}

// --- environment, encodings, console, calendar -----------------------------------------------------------------------

std::optional<std::string> environment(const char* name) {
  const wchar_t* const value = _wgetenv(wide_of(name).c_str());
  return value ? std::optional(utf8_of(value)) : std::nullopt;
}

void set_environment(const char* name, const std::optional<std::string>& value) {
  // An empty value removes a variable here.
  _wputenv_s(wide_of(name).c_str(), wide_of(value.value_or("")).c_str());
}

std::optional<std::string> decoded(std::string_view text, std::string_view encoding) {
  const auto page = code_page_of(encoding);
  if (!page) return std::nullopt;
  if (text.empty()) return std::string();
  const int bytes = int(text.size());
  const int size = MultiByteToWideChar(*page, MB_ERR_INVALID_CHARS, text.data(), bytes, nullptr, 0);
  if (size <= 0) return std::nullopt;
  std::wstring wide(std::size_t(size), L'\0');
  MultiByteToWideChar(*page, MB_ERR_INVALID_CHARS, text.data(), bytes, wide.data(), size);
  return utf8_of(wide);
}

namespace {

/// A program with a window has no streams where it was started from a console. They are that console's.
void use_console_of_parent() {
  if (GetStdHandle(STD_ERROR_HANDLE) || !AttachConsole(ATTACH_PARENT_PROCESS)) return;
  for (std::FILE* const stream : {stdout, stderr}) _wfreopen(L"CONOUT$", L"w", stream);
}

}  // namespace

std::vector<std::string> begin_program(int argc, char** argv) {
  use_console_of_parent();
  SetConsoleOutputCP(CP_UTF8);
  for (std::FILE* const stream : {stdin, stdout, stderr}) _setmode(_fileno(stream), _O_BINARY);
  // Arguments that are not those of main() are UTF-8 already.
  if (argc == 0 || __argc == 0 || std::strcmp(argv[0], __argv[0]) != 0) return {argv, argv + argc};
  int count = 0;
  wchar_t** const words = CommandLineToArgvW(GetCommandLineW(), &count);
  if (!words) return {argv, argv + argc};
  std::vector<std::string> arguments;
  for (int i = 0; i < count; ++i) arguments.push_back(utf8_of(words[i]));
  LocalFree(words);
  return arguments;
}

bool errors_are_on_terminal() {
  const HANDLE console = GetStdHandle(STD_ERROR_HANDLE);
  DWORD mode = 0;
  return GetConsoleMode(console, &mode) && SetConsoleMode(console, mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING);
}

bool utc_of(std::time_t time, std::tm& utc) {
  return gmtime_s(&utc, &time) == 0;
}

}  // namespace sightline::core::platform
