#include "sightline/importers/cad/internal/cad_import.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sightline/importers/cad/internal/cad_messages.h"
#include "sightline/importers/cad/internal/temporary_folder.h"
#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/loaded_module.h"
#include "sightline/importers/slc/internal/slc_scene.h"

extern char** environ;

namespace sightline::importers {
namespace {

namespace fs = std::filesystem;
using Read = decltype(&import_cad);

core::Expected<ImportReport> read_by_module(const fs::path& path, core::Scene& scene, core::NodeId parent,
                                            const ImportOptions& options) {
  static const LoadedModule module = load_module("libsightline_cad.so", "sightline_read_cad");
  if (!module.entry)
    return core::fail(fmt::format("{}: this format needs libsightline_cad.so beside the program: {}",
                                  path.filename().string(), module.error));
  return (*static_cast<const Read*>(module.entry))(path, scene, parent, options);
}

std::uint64_t memory_limit() {
  const auto pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
  return pages > 0 && size > 0 ? std::uint64_t(pages) / 4 * 3 * std::uint64_t(size) : 0;
}

std::uint64_t second_limit(const fs::path& path) {
  std::error_code ignored;
  return 120 + 60 * (std::uint64_t(fs::file_size(path, ignored)) >> 20);
}

/// The reader as a process: what it says, and how it ended. Killed when this goes.
class Reader {
 public:
  ~Reader() {
    if (messages_ >= 0) close(messages_);
    if (process_ > 0) {
      kill(process_, SIGKILL);
      wait();
    }
  }

  core::Expected<void> start(const fs::path& program, std::vector<std::string> arguments) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) return core::fail(std::string("no pipe: ") + std::strerror(errno));
    messages_ = ends[0];
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
      posix_spawn_file_actions_addopen(&actions, standard, "/dev/null", O_RDWR, 0);
    posix_spawn_file_actions_adddup2(&actions, ends[1], cad::kMessages);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const int failed = posix_spawn(&process_, program.c_str(), &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (failed == 0) return {};
    process_ = -1;
    return core::fail(fmt::format("{} cannot be started: {}", program.string(), std::strerror(failed)));
  }

  /// Waits a little for more; false at the end.
  bool listen() {
    constexpr int kMilliseconds = 50;
    pollfd ready{messages_, POLLIN, 0};
    if (poll(&ready, 1, kMilliseconds) <= 0) return true;
    std::array<char, 4096> buffer;
    const auto size = ::read(messages_, buffer.data(), buffer.size());
    if (size < 0) return errno == EINTR || errno == EAGAIN;
    said_.append(buffer.data(), std::size_t(size));
    take_lines();
    return size > 0;
  }

  int wait() {
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
    return status;
  }

  double share() const { return share_; }
  const std::string& error() const { return error_; }
  std::vector<fs::path>& side_files() { return side_files_; }

 private:
  void take_lines() {
    for (std::size_t end; (end = said_.find('\n')) != std::string::npos; said_.erase(0, end + 1)) {
      const std::string_view line = std::string_view(said_).substr(0, end),
                             text = line.substr(std::min<std::size_t>(2, end));
      if (line.starts_with(cad::kProgress)) std::from_chars(text.data(), text.data() + text.size(), share_);
      if (line.starts_with(cad::kSideFile)) side_files_.emplace_back(text);
      if (line.starts_with(cad::kError)) error_ = text;
    }
  }

  pid_t process_ = -1;
  int messages_ = -1;
  std::string said_, error_;
  double share_ = 0.0;
  std::vector<fs::path> side_files_;
};

/// Why a reader that said nothing has no result.
std::string end_of(int status, std::uint64_t seconds) {
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU)
    return fmt::format("Open CASCADE took more than {} s of processor time (reading in this process has no limit)",
                       seconds);
  if (WIFSIGNALED(status))
    return fmt::format("Open CASCADE crashed while it read this file ({})", strsignal(WTERMSIG(status)));
  return fmt::format("its reader ended with {}", WEXITSTATUS(status));
}

constexpr double kHandingOver = 0.05;  // share of the time

std::vector<std::string> arguments_for(const fs::path& path, const fs::path& result, const ImportOptions& options) {
  const auto option = [](const char* key, const auto& value) { return fmt::format("{}={}", key, value); };
  return {cad::kProgram,
          path.string(),
          result.string(),
          option(cad::kTolerance, options.chord_tolerance),
          option(cad::kAngle, options.chord_angle),
          option(cad::kLenient, int(options.lenient)),
          option(cad::kThreads, options.threads),
          option(cad::kMemory, memory_limit()),
          option(cad::kSeconds, second_limit(path))};
}

/// Waits for the reader's end, and returns its status; nothing where the caller cancels. `shown` rises.
std::optional<int> wait_for(Reader& reader, const ImportOptions& options, double& shown) {
  while (reader.listen()) {
    shown = std::max(shown, (1.0 - kHandingOver) * reader.share());
    if (options.progress && !options.progress(shown)) return std::nullopt;
  }
  return reader.wait();
}

core::Expected<ImportReport> take_over(const fs::path& path, const fs::path& result, core::Scene& scene,
                                       core::NodeId parent, const ImportOptions& options) {
  ImportOptions handing_over;
  if (options.progress)
    handing_over.progress = [&](double share) { return options.progress(1.0 - kHandingOver * (1.0 - share)); };
  auto report = read_slc(result, scene, parent, handing_over);
  if (!report) return report;
  report->from_cache = false;
  std::error_code ignored;
  report->bytes = fs::file_size(path, ignored);
  return report;
}

core::Expected<ImportReport> read_apart(const fs::path& path, core::Scene& scene, core::NodeId parent,
                                        const ImportOptions& options) {
  const std::string name = path.filename().string();
  const auto program = find_program(cad::kProgram);
  if (!program)
    return core::fail(
        fmt::format("{}: this format needs {} beside the program (package sightline-occt)", name, cad::kProgram));
  const TemporaryFolder folder;
  if (folder.path().empty()) return core::fail(fmt::format("{}: no temporary folder can be made", name));
  const fs::path result = folder.path() / "scene.slc";
  std::vector<std::string> arguments = arguments_for(path, result, options);
  std::string crash;  // of the first reader
  double shown = 0.0;
  for (;;) {
    Reader reader;
    if (auto started = reader.start(*program, arguments); !started)
      return core::fail(fmt::format("{}: {}", name, started.error().message));
    const auto status = wait_for(reader, options, shown);
    if (!status) return core::fail(std::string(kCancelled));
    if (WIFEXITED(*status) && WEXITSTATUS(*status) == 0) {
      auto report = take_over(path, result, scene, parent, options);
      if (!report) return report;
      report->side_files = std::move(reader.side_files());
      if (!crash.empty()) report->warnings.insert(report->warnings.begin(), {name, 0, crash + cad::shapes_alone(path)});
      return report;
    }
    const bool crashed = WIFSIGNALED(*status) && WTERMSIG(*status) != SIGXCPU;
    if (crash.empty() && !reader.error().empty()) return core::fail(reader.error());
    if (!crash.empty() || !crashed)
      return core::fail(fmt::format("{}: {}", name, crash.empty() ? end_of(*status, second_limit(path)) : crash));
    crash = end_of(*status, 0);
    arguments.push_back(fmt::format("{}=1", cad::kShapesAlone));
  }
}

}  // namespace

core::Expected<ImportReport> import_cad(const fs::path& path, core::Scene& scene, core::NodeId parent,
                                        const ImportOptions& options) {
  return with_whole_path(
      options.in_process ? read_by_module(path, scene, parent, options) : read_apart(path, scene, parent, options),
      path);
}

}  // namespace sightline::importers
