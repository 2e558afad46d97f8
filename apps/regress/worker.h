// Processes of the tool itself that draw tasks. A crash in a driver or a reader, and a kill, costs one of them and not
// the run.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/core/internal/platform/process.h"

namespace sightline::apps {

/// How a task ended that a worker had.
struct TaskEnd {
  std::size_t task = 0;
  bool drawn = false;  ///< its result is written
  bool lost = false;   ///< its worker died: another may try
  std::string why;     ///< how it died; otherwise why no result could be written
};

/// A place for one worker process at a time. A process that died is replaced when the next task comes.
class Worker {
 public:
  /// `command`: program and arguments of a process that calls serve_tasks(). `seconds`: after so many a task's process
  /// is killed; 0: never.
  Worker(std::vector<std::string> command, double seconds) : command_(std::move(command)), seconds_(seconds) {}

  bool busy() const { return task_.has_value(); }
  /// The model of the last task, which the process has in memory.
  std::optional<std::size_t> model() const { return process_.is_running() ? model_ : std::nullopt; }
  /// Precondition: not busy. Fails where no process can be started.
  core::Expected<void> begin(std::size_t task, std::size_t model, const std::string& key);
  /// Waits until step() has something to do for one of the workers; at most so long.
  static void wait(std::span<const Worker* const> workers, std::chrono::milliseconds most);
  /// Whether the task has ended. Never waits.
  std::optional<TaskEnd> step();

 private:
  core::Expected<void> start();
  TaskEnd end(bool drawn, bool lost, std::string why);
  std::string stop();  ///< how the process ended

  std::vector<std::string> command_;
  double seconds_;
  core::platform::ChildProcess process_;  // killed when this goes
  std::string read_;                      // of a line that is not complete
  std::optional<std::size_t> task_, model_;
  std::chrono::steady_clock::time_point begun_;
  bool too_slow_ = false;
};

/// Reads tasks from standard input and answers to the process that started this one, until the input ends. `run` draws
/// task number `task` if its key is `key`.
int serve_tasks(const std::function<core::Expected<void>(std::size_t task, const std::string& key)>& run);

}  // namespace sightline::apps
