#include "sightline/apps/regress/farm.h"

#include <algorithm>

namespace sightline::apps {
namespace {

constexpr int kMostDeaths = 2;                   // of workers with one task
constexpr std::chrono::milliseconds kWait(200);  // between looks at how long tasks take

}  // namespace

TaskQueue::TaskQueue(const Suite& suite, const std::vector<std::size_t>& tasks)
    : suite_(suite),
      waiting_(suite.models.size()),
      done_(suite.tasks.size()),
      deaths_(suite.tasks.size()),
      count_(tasks.size()) {
  for (const std::size_t task : tasks) waiting_[suite.tasks[task].model].push_back(task);
}

std::optional<std::size_t> TaskQueue::take(std::optional<std::size_t> model) {
  const auto fewer = [](const auto& a, const auto& b) { return a.size() < b.size(); };
  auto& from = model && !waiting_[*model].empty() ? waiting_[*model]
                                                  : *std::max_element(waiting_.begin(), waiting_.end(), fewer);
  if (from.empty()) return std::nullopt;
  const std::size_t task = from.front();
  from.pop_front();
  return task;
}

void TaskQueue::done(std::size_t task) {
  finished_ += !done_[task];  // a worker that was given up may still bring it
  done_[task] = true;
}

bool TaskQueue::lost(std::size_t task) {
  if (done_[task]) return true;
  if (++deaths_[task] < kMostDeaths) {
    waiting_[suite_.tasks[task].model].push_front(task);
    return true;
  }
  done(task);
  return false;
}

core::Expected<void> Farm::enter(const TaskEnd& end) {
  const Task& task = suite_.tasks[end.task];
  if (end.drawn) {
    queue_.done(end.task);
  } else if (!end.lost) {
    return core::fail(end.why);
  } else if (!queue_.lost(end.task)) {
    TaskResult result;
    result.key = task.key;
    result.files_key = suite_.files_key(task);
    result.error = end.why + ", as the one before";
    if (auto done = results_.write(task, result); !done) return done;
  }
  progress_(queue_.finished());
  return {};
}

core::Expected<void> Farm::run(std::vector<Worker>& workers) {
  while (!queue_.complete()) {
    std::vector<const Worker*> all;
    for (Worker& worker : workers) {
      if (!worker.busy())
        if (const auto task = queue_.take(worker.model()))
          if (auto done = worker.begin(*task, suite_.tasks[*task].model, suite_.tasks[*task].key); !done) return done;
      all.push_back(&worker);
    }
    Worker::wait(all, kWait);
    for (Worker& worker : workers)
      if (const auto end = worker.step())
        if (auto done = enter(*end); !done) return done;
  }
  return {};
}

}  // namespace sightline::apps
