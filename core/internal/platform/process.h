// Processes of the operating system. Internal.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"

namespace sightline::core::platform {

/// How a process ended.
struct ProcessEnd {
  enum class Kind { kExited, kOutOfTime, kCrashed };  // by itself, at its limit of time, or otherwise
  Kind kind = Kind::kExited;
  int code = 0;        ///< that it returned
  std::string reason;  ///< of a crash, such as "signal 9"
  std::string name;    ///< of that reason, such as "Killed"
};

/// A process that was started, with pipes. Killed when this goes.
class SIGHTLINE_API ChildProcess {
 public:
  struct Options {
    bool reads = false;      ///< its standard input is what write() says; otherwise nothing
    bool may_print = false;  ///< its output goes to this process's standard error; otherwise nowhere
    std::filesystem::path output = {}, errors = {};  ///< files that get its output instead; empty: none
  };
  /// `command`: the program's path, or a name that the system looks for, and its arguments. An error has the system's
  /// reason alone.
  static Expected<ChildProcess> start(const std::vector<std::string>& command, const Options& options);
  ChildProcess() = default;
  ChildProcess(ChildProcess&& other) noexcept { *this = std::move(other); }
  ChildProcess& operator=(ChildProcess&& other) noexcept {
    std::swap(process_, other.process_);
    std::swap(to_, other.to_);
    std::swap(from_, other.from_);
    return *this;
  }
  ~ChildProcess() {
    kill();
    wait();
  }

  bool is_running() const { return process_ != kNone; }  ///< or has ended, and nobody has asked how
  /// Writes all of it; false where nobody reads any more.
  bool write(std::string_view text);
  /// Reads what there is of its answers. Never waits. Nothing at their end.
  enum class Heard { kSomething, kNothing, kEnd };
  Heard read(std::string& to);
  /// Waits until one of the processes has answers, or their end, to read; at most so long.
  static void wait_for_answers(std::span<const ChildProcess* const> processes, std::chrono::milliseconds most);
  void kill();
  /// Closes the pipes, waits for the end, and says how it was. `write()` and `read()` may not follow.
  ProcessEnd wait();

 private:
  static constexpr std::intptr_t kNone = -1;
  void close_pipes();
  std::intptr_t process_ = kNone, to_ = kNone, from_ = kNone;
};

/// The pipe on which a process answers that ChildProcess started.
class SIGHTLINE_API AnswerPipe {
 public:
  /// Nothing in a process that was started otherwise.
  static std::optional<AnswerPipe> of_this_process();
  bool write(std::string_view text) const;  ///< all of it; false where nobody reads any more

 private:
  explicit AnswerPipe(std::intptr_t handle) : handle_(handle) {}
  std::intptr_t handle_;
};

/// Limits of what this process may use.
struct ProcessLimits {
  std::optional<std::uint64_t> memory;   ///< bytes of address space
  std::optional<std::uint64_t> seconds;  ///< of processor time
};
SIGHTLINE_API void limit_this_process(const ProcessLimits& limits);
/// A crash leaves no image of the memory behind.
SIGHTLINE_API void write_no_core_dumps();
/// This process is killed when the one that started it ends.
SIGHTLINE_API void end_with_parent();
/// As many files may be open as the system allows.
SIGHTLINE_API void allow_many_files();
/// Writing to a pipe that nobody reads fails, and ends no process.
SIGHTLINE_API void survive_broken_pipes();
/// Others come first, as far as the system can do that for one thread.
SIGHTLINE_API void lower_priority_of_this_thread();
/// Ends the process at once: no destructors of static objects run.
[[noreturn]] SIGHTLINE_API void end_at_once(int code);

/// The program that runs; empty where it cannot be told.
SIGHTLINE_API std::filesystem::path program_file();
/// A file that changes when the program does, to look at; not to start.
SIGHTLINE_API std::filesystem::path program_image();

}  // namespace sightline::core::platform
