#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <system_error>
#include <utility>

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sightline/core/internal/platform/modules.h"
#include "sightline/core/internal/platform/process.h"

extern char** environ;

namespace sightline::core::platform {
namespace {

namespace fs = std::filesystem;

/// Where a process finds the pipe for its answers.
constexpr int kAnswers = 3;

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(std::size_t(written));
  }
  return true;
}

struct Pipe {
  ~Pipe() {
    for (const int end : {read, write})
      if (end >= 0) close(end);
  }
  /// Closed in all other processes: otherwise the end of one would not show.
  bool open() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) return false;
    read = ends[0], write = ends[1];
    return true;
  }
  int read = -1, write = -1;
};

/// Says what becomes of the first descriptors of a process, and of its signals.
class SpawnSettings {
 public:
  SpawnSettings() {
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
    sigset_t defaults;
    sigemptyset(&defaults);
    sigaddset(&defaults, SIGPIPE);
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
  ~SpawnSettings() {
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
  }
  void write_to(int descriptor, const fs::path& file) {
    posix_spawn_file_actions_addopen(&actions, descriptor, file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  }
  void leave_empty(int descriptor) { posix_spawn_file_actions_addopen(&actions, descriptor, "/dev/null", O_RDWR, 0); }
  void take(int from, int as) { posix_spawn_file_actions_adddup2(&actions, from, as); }

  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
};

void limit(int what, std::uint64_t to) {
  rlimit limits{};
  getrlimit(decltype(RLIMIT_AS)(what), &limits);
  limits.rlim_cur = std::min<rlim_t>(limits.rlim_max, to);
  setrlimit(decltype(RLIMIT_AS)(what), &limits);
}

}  // namespace

// --- children --------------------------------------------------------------------------------------------------------

Expected<ChildProcess> ChildProcess::start(const std::vector<std::string>& command, const Options& options) {
  Pipe said, answers;
  if ((options.reads && !said.open()) || !answers.open()) return fail(std::string("no pipe: ") + std::strerror(errno));
  SpawnSettings settings;
  if (options.reads)
    settings.take(said.read, STDIN_FILENO);
  else
    settings.leave_empty(STDIN_FILENO);
  if (options.may_print) {
    settings.take(STDERR_FILENO, STDOUT_FILENO);
  } else {
    settings.leave_empty(STDOUT_FILENO);
    settings.leave_empty(STDERR_FILENO);
  }
  if (!options.output.empty()) settings.write_to(STDOUT_FILENO, options.output);
  if (!options.errors.empty()) settings.write_to(STDERR_FILENO, options.errors);
  settings.take(answers.write, kAnswers);
  std::vector<char*> arguments;
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  pid_t process = -1;
  const int failed =
      posix_spawnp(&process, arguments[0], &settings.actions, &settings.attributes, arguments.data(), environ);
  if (failed != 0) return fail(std::strerror(failed));
  ChildProcess made;
  made.process_ = process;
  made.to_ = std::exchange(said.write, -1);
  made.from_ = std::exchange(answers.read, -1);
  fcntl(int(made.from_), F_SETFL, O_NONBLOCK);
  return made;
}

bool ChildProcess::write(std::string_view text) {
  return write_all(int(to_), text);
}

ChildProcess::Heard ChildProcess::read(std::string& to) {
  std::array<char, 4096> bytes;
  for (;;) {
    const ssize_t count = ::read(int(from_), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) return Heard::kNothing;
    if (count <= 0) return Heard::kEnd;
    to.append(bytes.data(), std::size_t(count));
    return Heard::kSomething;
  }
}

void ChildProcess::wait_for_answers(std::span<const ChildProcess* const> processes, std::chrono::milliseconds most) {
  std::vector<pollfd> waits;
  for (const ChildProcess* const process : processes) waits.push_back({int(process->from_), POLLIN, 0});
  poll(waits.data(), nfds_t(waits.size()), int(most.count()));
}

void ChildProcess::kill() {
  if (process_ > 0) ::kill(pid_t(process_), SIGKILL);
}

ProcessEnd ChildProcess::wait() {
  close_pipes();
  ProcessEnd end;
  if (process_ <= 0) return end;
  int status = 0;
  while (waitpid(pid_t(process_), &status, 0) < 0 && errno == EINTR) {
  }
  process_ = kNone;
  if (WIFSIGNALED(status)) {
    end.kind = WTERMSIG(status) == SIGXCPU ? ProcessEnd::Kind::kOutOfTime : ProcessEnd::Kind::kCrashed;
    end.reason = "signal " + std::to_string(WTERMSIG(status));
    end.name = strsignal(WTERMSIG(status));
  } else {
    end.code = WEXITSTATUS(status);
  }
  return end;
}

void ChildProcess::close_pipes() {
  for (std::intptr_t* const end : {&to_, &from_}) {
    if (*end >= 0) close(int(*end));
    *end = kNone;
  }
}

std::optional<AnswerPipe> AnswerPipe::of_this_process() {
  if (fcntl(kAnswers, F_GETFD) < 0) return std::nullopt;
  return AnswerPipe(kAnswers);
}

bool AnswerPipe::write(std::string_view text) const {
  return write_all(int(handle_), text);
}

// --- this process ----------------------------------------------------------------------------------------------------

void limit_this_process(const ProcessLimits& limits) {
  if (limits.memory) limit(RLIMIT_AS, *limits.memory);
  if (limits.seconds) limit(RLIMIT_CPU, *limits.seconds);
}

void write_no_core_dumps() {
  limit(RLIMIT_CORE, 0);
}

void end_with_parent() {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
}

void allow_many_files() {
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) != 0) return;
  files.rlim_cur = files.rlim_max;
  (void)setrlimit(RLIMIT_NOFILE, &files);
}

void survive_broken_pipes() {
  std::signal(SIGPIPE, SIG_IGN);
}

void lower_priority_of_this_thread() {
  constexpr int kNiceness = 5;                    // a higher number leaves a loader so little that pages come late
  (void)setpriority(PRIO_PROCESS, 0, kNiceness);  // on Linux that is the thread
}

void end_at_once(int code) {
  _exit(code);
}

fs::path program_file() {
  std::error_code ignored;
  return fs::read_symlink(program_image(), ignored);
}

fs::path program_image() {
  return "/proc/self/exe";
}

// --- modules ---------------------------------------------------------------------------------------------------------

Expected<void*> open_module(const fs::path& file) {
  void* const module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (module) return module;
  return fail(symbol_error());
}

void* opened_module(const fs::path& file) {
  return dlopen(file.c_str(), RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE);
}

void* find_in_module(void* module, const char* symbol) {
  return dlsym(module, symbol);
}

std::string symbol_error() {
  const char* const said = dlerror();
  return said ? said : "";
}

fs::path module_of(const void* address) {
  Dl_info info{};
  if (dladdr(address, &info) == 0 || !info.dli_fname) return {};
  return info.dli_fname;
}

}  // namespace sightline::core::platform
