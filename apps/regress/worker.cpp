#include "sightline/apps/regress/worker.h"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <iostream>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sightline/apps/regress/task_result.h"

extern char** environ;

namespace sightline::apps {
namespace {

/// Writes all of it; false where nobody reads.
bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(std::size_t(written));
  }
  return true;
}

void close_end(int& descriptor) {
  if (descriptor >= 0) close(descriptor);
  descriptor = -1;
}

}  // namespace

Worker::Worker(Worker&& other) noexcept
    : command_(std::move(other.command_)),
      seconds_(other.seconds_),
      pid_(std::exchange(other.pid_, 0)),
      to_(std::exchange(other.to_, -1)),
      from_(std::exchange(other.from_, -1)),
      read_(std::move(other.read_)),
      task_(other.task_),
      model_(other.model_),
      begun_(other.begun_) {}

Worker::~Worker() {
  if (pid_ > 0) kill(pid_, SIGKILL);
  stop();
}

core::Expected<void> Worker::start() {
  // Closed in all other workers: otherwise the end of one would not show.
  int tasks[2], answers[2];
  if (pipe2(tasks, O_CLOEXEC) != 0) return core::fail(std::string("no pipe: ") + std::strerror(errno));
  if (pipe2(answers, O_CLOEXEC) != 0) {
    const int reason = errno;
    close(tasks[0]), close(tasks[1]);
    return core::fail(std::string("no pipe: ") + std::strerror(reason));
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, tasks[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);  // for what drivers print
  posix_spawn_file_actions_adddup2(&actions, answers[1], kAnswers);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  std::vector<char*> arguments;
  for (const std::string& argument : command_) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  const int failed = posix_spawn(&pid_, arguments[0], &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(tasks[0]), close(answers[1]);
  to_ = tasks[1], from_ = answers[0];
  fcntl(from_, F_SETFL, O_NONBLOCK);
  read_.clear();
  if (failed == 0) return {};
  pid_ = 0;
  stop();
  return core::fail(command_[0] + ": cannot be started: " + std::strerror(failed));
}

core::Expected<void> Worker::begin(std::size_t task, std::size_t model, const std::string& key) {
  const std::string line = std::to_string(task) + " " + key + "\n";
  // A process that died between two tasks takes none with it.
  if (pid_ > 0 && !write_all(to_, line)) stop();
  if (pid_ == 0) {
    if (auto done = start(); !done) return done;
    write_all(to_, line);  // where that fails, step() sees it
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
    kill(pid_, SIGKILL);
  }
  char bytes[512];
  for (;;) {
    const ssize_t count = read(from_, bytes, sizeof bytes);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) return std::nullopt;
    if (count <= 0) return end(false, true, stop());
    read_.append(bytes, std::size_t(count));
    const std::size_t line_end = read_.find('\n');
    if (line_end == std::string::npos) continue;
    const std::string line = read_.substr(0, line_end);
    read_.erase(0, line_end + 1);
    return end(line == "drawn", false, line == "drawn" ? "" : line);
  }
}

TaskEnd Worker::end(bool drawn, bool lost, std::string why) {
  if (lost && too_slow_) why = "took more than " + number(seconds_, "%g") + " s";
  TaskEnd ended{*task_, drawn, lost, std::move(why)};
  task_.reset();
  return ended;
}

std::string Worker::stop() {
  close_end(to_);
  close_end(from_);
  if (pid_ <= 0) return "";
  int status = 0;
  while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = 0;
  if (WIFSIGNALED(status))
    return "its process was ended by signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) +
           ")";
  return "its process ended with exit code " + std::to_string(WEXITSTATUS(status));
}

int serve_tasks(int descriptor,
                const std::function<core::Expected<void>(std::size_t task, const std::string& key)>& run) {
  std::size_t task = 0;
  std::string key;
  while (std::cin >> task >> key) {
    const auto done = run(task, key);
    std::string answer = done ? "drawn" : done.error().message;
    for (char& c : answer)
      if (c == '\n') c = ' ';
    if (!write_all(descriptor, answer + "\n")) return 1;
  }
  return 0;
}

}  // namespace sightline::apps
