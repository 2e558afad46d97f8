#include "sightline/apps/regress/worker.h"

#include <iostream>

#include "sightline/apps/regress/task_result.h"

namespace sightline::apps {

using core::platform::ChildProcess, core::platform::ProcessEnd;

core::Expected<void> Worker::start() {
  auto process = ChildProcess::start(command_, {.reads = true, .may_print = true});  // for what drivers print
  if (!process) return core::fail(command_[0] + ": cannot be started: " + process.error().message);
  process_ = std::move(*process);
  read_.clear();
  return {};
}

core::Expected<void> Worker::begin(std::size_t task, std::size_t model, const std::string& key) {
  const std::string line = std::to_string(task) + " " + key + "\n";
  // A process that died between two tasks takes none with it.
  if (process_.is_running() && !process_.write(line)) stop();
  if (!process_.is_running()) {
    if (auto done = start(); !done) return done;
    process_.write(line);  // where that fails, step() sees it
  }
  task_ = task;
  model_ = model;
  begun_ = std::chrono::steady_clock::now();
  too_slow_ = false;
  return {};
}

std::optional<TaskEnd> Worker::step() {
  if (!task_) return std::nullopt;
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begun_;
  if (seconds_ > 0.0 && taken.count() > seconds_ && !too_slow_) {
    too_slow_ = true;
    process_.kill();
  }
  for (;;) {
    const std::size_t line_end = read_.find('\n');
    if (line_end != std::string::npos) {
      const std::string line = read_.substr(0, line_end);
      read_.erase(0, line_end + 1);
      return end(line == "drawn", false, line == "drawn" ? "" : line);
    }
    const auto heard = process_.read(read_);
    if (heard == ChildProcess::Heard::kNothing) return std::nullopt;
    if (heard == ChildProcess::Heard::kEnd) return end(false, true, stop());
  }
}

void Worker::wait(std::span<const Worker* const> workers, std::chrono::milliseconds most) {
  std::vector<const ChildProcess*> busy;
  for (const Worker* const worker : workers)
    if (worker->busy()) busy.push_back(&worker->process_);
  ChildProcess::wait_for_answers(busy, most);
}

TaskEnd Worker::end(bool drawn, bool lost, std::string why) {
  if (lost && too_slow_) why = "took more than " + number(seconds_, "%g") + " s";
  TaskEnd ended{*task_, drawn, lost, std::move(why)};
  task_.reset();
  return ended;
}

std::string Worker::stop() {
  const ProcessEnd end = process_.wait();
  if (end.kind != ProcessEnd::Kind::kExited) return "its process was ended by " + end.reason + " (" + end.name + ")";
  return "its process ended with exit code " + std::to_string(end.code);
}

int serve_tasks(const std::function<core::Expected<void>(std::size_t task, const std::string& key)>& run) {
  const auto starter = core::platform::AnswerPipe::of_this_process();
  std::size_t task = 0;
  std::string key;
  while (std::cin >> task >> key) {
    const auto done = run(task, key);
    std::string answer = done ? "drawn" : done.error().message;
    for (char& c : answer)
      if (c == '\n') c = ' ';
    if (!starter || !starter->write(answer + "\n")) return 1;
  }
  return 0;
}

}  // namespace sightline::apps
