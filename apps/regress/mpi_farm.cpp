#include "sightline/apps/regress/mpi_farm.h"

#include <algorithm>
#include <thread>

#include <mpi.h>

namespace sightline::apps {
namespace {

using Json = json::Value;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr int kTag = 7;
constexpr milliseconds kPoll(5);
constexpr milliseconds kHeartbeat(500);

struct Message {
  int rank;
  Json content;
};

// A message sent is buffered by MPI, so that a receiver that died stops nobody.
void send(int rank, const Json& content) {
  const std::string text = content.dump();
  MPI_Send(text.data(), int(text.size()), MPI_CHAR, rank, kTag, MPI_COMM_WORLD);
}

std::optional<Message> receive() {
  int there = 0, bytes = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, kTag, MPI_COMM_WORLD, &there, &status);
  if (there == 0) return std::nullopt;
  MPI_Get_count(&status, MPI_CHAR, &bytes);
  std::string text(std::size_t(bytes), '\0');
  MPI_Recv(text.data(), bytes, MPI_CHAR, status.MPI_SOURCE, kTag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return Message{status.MPI_SOURCE, json::parse(text).value_or(Json())};
}

Json to_json(const TaskEnd& end) {
  return {{"task", end.task}, {"drawn", end.drawn}, {"lost", end.lost}, {"why", end.why}};
}

TaskEnd task_end(const Json& in) {
  return {in["task"].get<std::size_t>(), in["drawn"].get<bool>(), in["lost"].get<bool>(), in["why"].get<std::string>()};
}

/// Waits a little, or until the worker has something to tell.
void wait_for(const Worker& worker) {
  const Worker* const one = &worker;
  Worker::wait({&one, 1}, kPoll);
}

core::Expected<void> begin(Worker& worker, const Suite& suite, std::size_t task) {
  return worker.begin(task, suite.tasks[task].model, suite.tasks[task].key);
}

/// What rank 0 knows of another rank.
struct Rank {
  Clock::time_point heard = Clock::now();
  std::optional<std::size_t> task, model;
  bool asks = false;  // for a task
  bool gone = false;
};

class Master {
 public:
  Master(Farm& farm, Worker& worker, double silence) : farm_(farm), worker_(worker), silence_(silence) {
    int size = 1;
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    ranks_.resize(std::size_t(size));
  }

  /// False: ranks were lost.
  bool all_live() const {
    return std::none_of(ranks_.begin(), ranks_.end(), [](const Rank& rank) { return rank.gone; });
  }

  core::Expected<void> run() {
    auto done = draw_all();
    for (std::size_t r = 1; r < ranks_.size(); ++r)
      if (!ranks_[r].gone) stop(r);
    return done;
  }

 private:
  core::Expected<void> draw_all() {
    while (!farm_.queue().complete()) {
      if (!worker_.busy())
        if (const auto task = farm_.queue().take(worker_.model()))
          if (auto done = begin(worker_, farm_.suite(), *task); !done) return done;
      wait_for(worker_);
      if (const auto end = worker_.step())
        if (auto done = farm_.enter(*end); !done) return done;
      while (const auto message = receive())
        if (auto done = hear(*message); !done) return done;
      for (std::size_t r = 1; r < ranks_.size(); ++r) {
        if (auto done = give_up_if_silent(ranks_[r], r); !done) return done;
        hand_out(ranks_[r], int(r));
      }
    }
    return {};
  }

  core::Expected<void> hear(const Message& message) {
    Rank& rank = ranks_[std::size_t(message.rank)];
    rank.heard = Clock::now();
    rank.gone = false;
    if (message.content.contains("asks")) rank.asks = true;
    if (message.content.contains("fails")) return core::fail(message.content["fails"].get<std::string>());
    if (!message.content.contains("end")) return {};
    const TaskEnd end = task_end(message.content["end"]);
    if (rank.task != end.task) return end.drawn ? farm_.enter(end) : core::Expected<void>();  // it was given up
    rank.task.reset();
    if (end.lost) rank.model.reset();
    return farm_.enter(end);
  }

  core::Expected<void> give_up_if_silent(Rank& rank, std::size_t number) {
    const std::chrono::duration<double> silent = Clock::now() - rank.heard;
    if (rank.gone || silent.count() < silence_) return {};
    rank.gone = true;
    rank.asks = false;
    rank.model.reset();
    std::fprintf(stderr, "warning: rank %zu is silent and is given up\n", number);
    if (!rank.task) return {};
    const std::size_t task = *rank.task;
    rank.task.reset();
    return farm_.enter({task, false, true, "its rank was lost"});
  }

  void hand_out(Rank& rank, int number) {
    if (!rank.asks || rank.gone) return;
    const auto task = farm_.queue().take(rank.model);
    if (!task) return;
    rank.asks = false;
    rank.task = *task;
    rank.model = farm_.suite().tasks[*task].model;
    send(number, {{"task", *task}});
  }

  void stop(std::size_t rank) { send(int(rank), {{"stop", true}}); }

  Farm& farm_;
  Worker& worker_;
  double silence_;
  std::vector<Rank> ranks_;
};

/// Draws a task, and tells rank 0 now and then that this rank lives.
TaskEnd draw(Worker& worker) {
  Clock::time_point told = Clock::now();
  for (;;) {
    wait_for(worker);
    if (const auto end = worker.step()) return *end;
    if (Clock::now() - told < kHeartbeat) continue;
    told = Clock::now();
    send(0, {{"lives", true}});
  }
}

}  // namespace

core::Expected<void> run_mpi_farm(Farm& farm, Worker& worker, double silence, MpiSession& session) {
  Master master(farm, worker, silence);
  auto done = master.run();
  if (!master.all_live()) session.set_ranks_lost();
  return done;
}

core::Expected<void> serve_mpi_farm(const Suite& suite, Worker& worker) {
  Json news = {{"asks", true}};
  Clock::time_point told;
  for (;;) {
    send(0, news);
    told = Clock::now();
    std::optional<Message> answer;
    while (!(answer = receive())) {
      std::this_thread::sleep_for(kPoll);
      if (Clock::now() - told < kHeartbeat) continue;
      told = Clock::now();
      send(0, {{"lives", true}});
    }
    if (answer->content.contains("stop")) return {};
    const auto task = answer->content["task"].get<std::size_t>();
    if (auto done = begin(worker, suite, task); !done) {
      news = {{"fails", done.error().message}};
      continue;
    }
    news = {{"asks", true}, {"end", to_json(draw(worker))}};
  }
}

}  // namespace sightline::apps
