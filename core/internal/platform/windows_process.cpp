#include <algorithm>
#include <array>
#include <cstdlib>
#include <cwchar>
#include <memory>
#include <utility>

#include "sightline/core/internal/platform/console.h"
#include "sightline/core/internal/platform/environment.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/core/internal/platform/modules.h"
#include "sightline/core/internal/platform/process.h"
#include "sightline/core/internal/platform/windows.h"

namespace sightline::core::platform {
namespace {

namespace fs = std::filesystem;

/// Where a process finds the pipe for its answers: the number of a handle that it inherits.
constexpr const wchar_t* kAnswers = L"SIGHTLINE_ANSWERS";
/// The code of a process that was killed. No program returns it.
constexpr DWORD kKilled = 0xe0534c01;

struct CloseHandleOf {
  void operator()(void* handle) const {
    if (handle != INVALID_HANDLE_VALUE) CloseHandle(handle);
  }
};
using Handle = std::unique_ptr<void, CloseHandleOf>;

HANDLE handle_of(std::intptr_t value) {
  return reinterpret_cast<HANDLE>(value);
}

bool write_all(HANDLE to, std::string_view text) {
  while (!text.empty()) {
    DWORD written = 0;
    if (!WriteFile(to, text.data(), DWORD(std::min<std::size_t>(text.size(), 1u << 20)), &written, nullptr))
      return false;
    text.remove_prefix(written);
  }
  return true;
}

/// As programs take a command line apart again: a quote and backslashes before it get one more backslash each.
std::wstring in_quotes(const std::wstring& argument) {
  std::wstring text = L"\"";
  std::size_t backslashes = 0;
  for (const wchar_t c : argument) {
    if (c == L'"') text.append(backslashes + 1, L'\\');
    backslashes = c == L'\\' ? backslashes + 1 : 0;
    text += c;
  }
  return text.append(backslashes, L'\\') + L"\"";
}
std::wstring quoted(const std::wstring& argument) {
  const bool plain = !argument.empty() && argument.find_first_of(L" \t\n\v\"") == std::wstring::npos;
  return plain ? argument : in_quotes(argument);
}

/// Ends of pipes: this process's is not inherited.
struct Pipe {
  bool open(bool child_reads) {
    constexpr DWORD kBuffer = 1 << 16;
    HANDLE from = nullptr, to = nullptr;
    if (!CreatePipe(&from, &to, nullptr, kBuffer)) return false;
    (child_reads ? child : own).reset(from);
    (child_reads ? own : child).reset(to);
    return SetHandleInformation(child.get(), HANDLE_FLAG_INHERIT, HANDLE_FLAG_INHERIT) != 0;
  }
  Handle child, own;
};

/// This process's environment, and one more variable.
std::wstring environment_with(std::wstring_view name, const std::wstring& value) {
  std::wstring block;
  wchar_t* const all = GetEnvironmentStringsW();
  for (const wchar_t* one = all; *one; one += std::wcslen(one) + 1)
    if (!std::wstring_view(one).starts_with(std::wstring(name) + L"=")) block.append(one).push_back(L'\0');
  FreeEnvironmentStringsW(all);
  block.append(name).append(L"=").append(value).push_back(L'\0');
  return block + L'\0';
}

/// A list of the only handles that a process inherits.
class Inherited {
 public:
  explicit Inherited(std::vector<HANDLE> handles) : handles_(std::move(handles)) {
    std::sort(handles_.begin(), handles_.end());
    handles_.erase(std::unique(handles_.begin(), handles_.end()), handles_.end());
    std::erase_if(handles_, [](HANDLE handle) { return !handle || handle == INVALID_HANDLE_VALUE; });
    SIZE_T bytes = 0;
    InitializeProcThreadAttributeList(nullptr, 1, 0, &bytes);
    memory_.resize(bytes);
    good_ = InitializeProcThreadAttributeList(list(), 1, 0, &bytes) &&
            UpdateProcThreadAttribute(list(), 0, PROC_THREAD_ATTRIBUTE_HANDLE_LIST, handles_.data(),
                                      handles_.size() * sizeof(HANDLE), nullptr, nullptr);
  }
  Inherited(const Inherited&) = delete;
  Inherited& operator=(const Inherited&) = delete;
  ~Inherited() {
    if (good_) DeleteProcThreadAttributeList(list());
  }
  bool good() const { return good_; }
  LPPROC_THREAD_ATTRIBUTE_LIST list() { return reinterpret_cast<LPPROC_THREAD_ATTRIBUTE_LIST>(memory_.data()); }

 private:
  std::vector<HANDLE> handles_;
  std::vector<unsigned char> memory_;
  bool good_ = false;
};

/// Processes started by this one end with it: the system kills what is in the job when its last handle closes.
HANDLE job_of_children() {
  static const HANDLE job = [] {
    const HANDLE made = CreateJobObjectW(nullptr, nullptr);
    JOBOBJECT_EXTENDED_LIMIT_INFORMATION limits{};
    limits.BasicLimitInformation.LimitFlags = JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE;
    if (made) SetInformationJobObject(made, JobObjectExtendedLimitInformation, &limits, sizeof limits);
    return made;
  }();
  return job;
}

Handle open_to_inherit(const fs::path& file, DWORD access, DWORD how) {
  SECURITY_ATTRIBUTES inherited{sizeof inherited, nullptr, TRUE};
  constexpr DWORD kShared = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;
  return Handle(CreateFileW(file.c_str(), access, kShared, &inherited, how, FILE_ATTRIBUTE_NORMAL, nullptr));
}

Handle null_device() {
  return open_to_inherit(L"NUL", GENERIC_READ | GENERIC_WRITE, OPEN_EXISTING);
}

/// This process's standard error as another may inherit it; the null device where it has none.
Handle errors_to_inherit() {
  HANDLE copy = nullptr;
  const HANDLE errors = GetStdHandle(STD_ERROR_HANDLE), self = GetCurrentProcess();
  if (errors && errors != INVALID_HANDLE_VALUE &&
      DuplicateHandle(self, errors, self, &copy, 0, TRUE, DUPLICATE_SAME_ACCESS))
    return Handle(copy);
  return null_device();
}

Expected<Handle> create_process(const std::vector<std::string>& command, std::array<HANDLE, 4> handles) {
  std::wstring line;
  for (const std::string& argument : command) line += (line.empty() ? L"" : L" ") + quoted(wide_of(argument));
  Inherited inherited(std::vector<HANDLE>(handles.begin(), handles.end()));
  if (!inherited.good()) return fail(words_of(last_error()));
  std::wstring environment = environment_with(kAnswers, std::to_wstring(std::intptr_t(handles[3])));
  STARTUPINFOEXW start{};
  start.StartupInfo.cb = sizeof start;
  start.StartupInfo.dwFlags = STARTF_USESTDHANDLES;
  start.StartupInfo.hStdInput = handles[0];
  start.StartupInfo.hStdOutput = handles[1];
  start.StartupInfo.hStdError = handles[2];
  start.lpAttributeList = inherited.list();
  PROCESS_INFORMATION made{};
  // Without a path of its own, the system looks for the program of the line, and adds ".exe".
  constexpr DWORD kHow = EXTENDED_STARTUPINFO_PRESENT | CREATE_SUSPENDED | CREATE_UNICODE_ENVIRONMENT;
  if (!CreateProcessW(nullptr, line.data(), nullptr, nullptr, TRUE, kHow, environment.data(), nullptr,
                      &start.StartupInfo, &made))
    return fail(words_of(last_error()));
  if (job_of_children()) AssignProcessToJobObject(job_of_children(), made.hProcess);
  ResumeThread(made.hThread);
  CloseHandle(made.hThread);
  return Handle(made.hProcess);
}

const char* name_of_crash(DWORD code) {
  switch (code) {
    case EXCEPTION_ACCESS_VIOLATION:
      return "access violation";
    case EXCEPTION_STACK_OVERFLOW:
      return "stack overflow";
    case EXCEPTION_ILLEGAL_INSTRUCTION:
      return "illegal instruction";
    case EXCEPTION_INT_DIVIDE_BY_ZERO:
      return "division by zero";
    case kKilled:
      return "Killed";
    default:
      return "unknown";
  }
}

}  // namespace

// --- children --------------------------------------------------------------------------------------------------------

std::string shell_word(const std::string& word) {
  constexpr const char* kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./,:=+-\\~()";
  const bool plain = !word.empty() && word.find_first_not_of(kPlain) == std::string::npos;
  return plain ? word : utf8_of(in_quotes(wide_of(word)));
}

Expected<ChildProcess> ChildProcess::start(const std::vector<std::string>& command, const Options& options) {
  Pipe said, answers;
  if ((options.reads && !said.open(true)) || !answers.open(false)) return fail("no pipe: " + words_of(last_error()));
  const Handle nothing = null_device(), printed = options.may_print ? errors_to_inherit() : null_device();
  Handle output, errors;
  if (!options.output.empty()) output = open_to_inherit(options.output, GENERIC_WRITE, CREATE_ALWAYS);
  if (!options.errors.empty()) errors = open_to_inherit(options.errors, GENERIC_WRITE, CREATE_ALWAYS);
  auto process =
      create_process(command, {options.reads ? said.child.get() : nothing.get(), output ? output.get() : printed.get(),
                               errors ? errors.get() : printed.get(), answers.child.get()});
  if (!process) return tl::unexpected(process.error());
  ChildProcess made;
  made.process_ = std::intptr_t(process->release());
  if (options.reads) made.to_ = std::intptr_t(said.own.release());
  made.from_ = std::intptr_t(answers.own.release());
  return made;
}

bool ChildProcess::write(std::string_view text) {
  return write_all(handle_of(to_), text);
}

ChildProcess::Heard ChildProcess::read(std::string& to) {
  std::array<char, 4096> bytes;
  DWORD there = 0, got = 0;
  if (!PeekNamedPipe(handle_of(from_), nullptr, 0, nullptr, &there, nullptr)) return Heard::kEnd;
  if (there == 0) return Heard::kNothing;
  if (!ReadFile(handle_of(from_), bytes.data(), DWORD(bytes.size()), &got, nullptr)) return Heard::kEnd;
  to.append(bytes.data(), got);
  return Heard::kSomething;
}

void ChildProcess::wait_for_answers(std::span<const ChildProcess* const> processes, std::chrono::milliseconds most) {
  // Nobody can wait for pipes of this kind, so they are looked at now and then.
  const auto end = std::chrono::steady_clock::now() + most;
  DWORD pause = 0;
  for (;;) {
    for (const ChildProcess* const process : processes) {
      DWORD there = 0;
      if (!PeekNamedPipe(handle_of(process->from_), nullptr, 0, nullptr, &there, nullptr) || there > 0) return;
    }
    if (std::chrono::steady_clock::now() >= end) return;
    Sleep(pause);
    pause = std::min<DWORD>(pause + 1, 5);
  }
}

void ChildProcess::kill() {
  if (process_ != kNone) TerminateProcess(handle_of(process_), kKilled);
}

ProcessEnd ChildProcess::wait() {
  close_pipes();
  ProcessEnd end;
  if (process_ == kNone) return end;
  DWORD code = 0;
  WaitForSingleObject(handle_of(process_), INFINITE);
  GetExitCodeProcess(handle_of(process_), &code);
  CloseHandle(handle_of(process_));
  process_ = kNone;
  constexpr DWORD kFirstCrash = 0xc0000000;
  if (code == ERROR_NOT_ENOUGH_QUOTA) {
    end.kind = ProcessEnd::Kind::kOutOfTime;
    end.reason = "its limit", end.name = "out of time";
  } else if (code >= kFirstCrash) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "exception 0x%08lx", code);
    end.kind = ProcessEnd::Kind::kCrashed;
    end.reason = text.data(), end.name = name_of_crash(code);
  } else {
    end.code = int(code);
  }
  return end;
}

void ChildProcess::close_pipes() {
  for (std::intptr_t* const end : {&to_, &from_}) {
    if (*end != kNone) CloseHandle(handle_of(*end));
    *end = kNone;
  }
}

std::optional<AnswerPipe> AnswerPipe::of_this_process() {
  // Programs that this one starts do not inherit the handle, whose number may be another's there.
  static const std::intptr_t handle = [] {
    const wchar_t* const number = _wgetenv(kAnswers);
    const auto read = number ? std::intptr_t(std::wcstoll(number, nullptr, 10)) : 0;
    _wputenv_s(kAnswers, L"");
    return read;
  }();
  if (handle == 0 || GetFileType(handle_of(handle)) != FILE_TYPE_PIPE) return std::nullopt;
  return AnswerPipe(handle);
}

bool AnswerPipe::write(std::string_view text) const {
  return write_all(handle_of(handle_), text);
}

// --- this process ----------------------------------------------------------------------------------------------------

void limit_this_process(const ProcessLimits& limits) {
  constexpr std::uint64_t kSecond = 10'000'000;  // of 100 ns
  static const HANDLE job = CreateJobObjectW(nullptr, nullptr);
  if (!job || !AssignProcessToJobObject(job, GetCurrentProcess())) return;
  JOBOBJECT_EXTENDED_LIMIT_INFORMATION to{};
  if (limits.memory) {
    to.BasicLimitInformation.LimitFlags |= JOB_OBJECT_LIMIT_PROCESS_MEMORY;
    to.ProcessMemoryLimit = std::size_t(*limits.memory);
  }
  if (limits.seconds) {
    to.BasicLimitInformation.LimitFlags |= JOB_OBJECT_LIMIT_PROCESS_TIME;
    to.BasicLimitInformation.PerProcessUserTimeLimit.QuadPart = LONGLONG(*limits.seconds * kSecond);
  }
  SetInformationJobObject(job, JobObjectExtendedLimitInformation, &to, sizeof to);
}

void write_no_core_dumps() {
  SetErrorMode(SEM_FAILCRITICALERRORS | SEM_NOGPFAULTERRORBOX);  // and shows no window, which would wait for somebody
}

void end_with_parent() {}  // the parent's job sees to it

void allow_many_files() {}  // mapped files count for no limit here

void survive_broken_pipes() {}  // there are no signals

void lower_priority_of_this_thread() {
  SetThreadPriority(GetCurrentThread(), THREAD_PRIORITY_BELOW_NORMAL);
}

void end_at_once(int code) {
  TerminateProcess(GetCurrentProcess(), DWORD(code));
  std::abort();
}

fs::path program_file() {
  constexpr std::size_t kLongest = 32768;
  std::wstring name(kLongest, L'\0');
  name.resize(GetModuleFileNameW(nullptr, name.data(), DWORD(name.size())));
  return name;
}

fs::path program_image() {
  return program_file();
}

// --- modules ---------------------------------------------------------------------------------------------------------

Expected<void*> open_module(const fs::path& file) {
  // A library's own libraries may lie beside it.
  const DWORD beside = file.is_absolute() ? LOAD_LIBRARY_SEARCH_DLL_LOAD_DIR : 0;
  fs::path name = file;
  name.make_preferred();
  const HMODULE module = LoadLibraryExW(name.c_str(), nullptr, LOAD_LIBRARY_SEARCH_DEFAULT_DIRS | beside);
  if (!module) return fail(words_of(last_error()));
  HMODULE kept = nullptr;
  GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_PIN,
                     reinterpret_cast<const wchar_t*>(module), &kept);
  return reinterpret_cast<void*>(module);
}

void* opened_module(const fs::path& file) {
  HMODULE module = nullptr;
  return GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_PIN, file.c_str(), &module) ? module : nullptr;
}

void* find_in_module(void* module, const char* symbol) {
  return reinterpret_cast<void*>(GetProcAddress(static_cast<HMODULE>(module), symbol));
}

std::string symbol_error() {
  return words_of(last_error());
}

fs::path module_of(const void* address) {
  constexpr std::size_t kLongest = 32768;
  HMODULE module = nullptr;
  if (!GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                          static_cast<const wchar_t*>(address), &module))
    return {};
  std::wstring name(kLongest, L'\0');
  name.resize(GetModuleFileNameW(module, name.data(), DWORD(name.size())));
  return name;
}

}  // namespace sightline::core::platform
