// Hands tasks out to workers, here or on other machines, until each has a result.
#pragma once

#include <deque>
#include <functional>

#include "sightline/apps/regress/task_result.h"
#include "sightline/apps/regress/worker.h"

namespace sightline::apps {

/// Tasks that are not done, and how often their workers died.
class TaskQueue {
 public:
  TaskQueue(const Suite& suite, const std::vector<std::size_t>& tasks);

  /// The next task for a worker that has read `model`: one of that model where there is one, else the first of the
  /// model with most tasks left. Nothing while all that is left is in others' hands.
  std::optional<std::size_t> take(std::optional<std::size_t> model);
  void done(std::size_t task);
  /// Its worker died: another one may take it. False where that was the second time: the task counts as done.
  bool lost(std::size_t task);
  std::size_t count() const { return count_; }
  std::size_t finished() const { return finished_; }
  bool complete() const { return finished_ == count_; }

 private:
  const Suite& suite_;
  std::vector<std::deque<std::size_t>> waiting_;  // by model
  std::vector<bool> done_;
  std::vector<std::uint8_t> deaths_;
  std::size_t count_ = 0, finished_ = 0;
};

/// What every form of the farm does with a task that has ended.
class Farm {
 public:
  Farm(const Suite& suite, const ResultFolder& results, const std::vector<std::size_t>& tasks,
       std::function<void(std::size_t finished)> progress)
      : suite_(suite), results_(results), queue_(suite, tasks), progress_(std::move(progress)) {}

  TaskQueue& queue() { return queue_; }
  const Suite& suite() const { return suite_; }
  /// Fails where a worker could not write its result: then no other could.
  core::Expected<void> enter(const TaskEnd& end);
  /// Draws all with workers of this process.
  core::Expected<void> run(std::vector<Worker>& workers);

 private:
  const Suite& suite_;
  const ResultFolder& results_;
  TaskQueue queue_;
  std::function<void(std::size_t)> progress_;
};

}  // namespace sightline::apps
