// sightline-regress: images of many views of many models against references, by many processes.

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/mpi/session.h"
#include "sightline/apps/regress/farm.h"
#include "sightline/apps/regress/reports.h"
#include "sightline/apps/regress/task_drawer.h"
#include "sightline/core/internal/platform/process.h"
#if SIGHTLINE_HAS_MPI
#include "sightline/apps/regress/mpi_farm.h"
#endif

namespace {

using namespace sightline;
using apps::attempt, apps::fail, apps::need;
namespace fs = std::filesystem;
using Tasks = std::vector<std::size_t>;  // by their place in the suite

constexpr int kMostWorkers = 256;

struct Options {
  std::string suite, out = "regress", shard, images = "failed", html, junit, json_file;
  std::vector<std::string> only, from;
  int workers = 1;
  double timeout = 0.0, silence = 15.0;
  bool mpi = false, resume = false, merge = false, accept = false, list = false, quiet = false, worker = false;
  apps::Limits limits;
  engine::Renderer renderer = {};
  gl::ContextPlatform platform = {};
};

/// "2/5" as {1, 5}.
core::Expected<std::array<std::size_t, 2>> parse_shard(const std::string& text) {
  unsigned i = 0, n = 0;
  int used = 0;
  const bool parsed = std::sscanf(text.c_str(), "%6u/%6u%n", &i, &n, &used) == 2 && used == int(text.size());
  if (!parsed || i < 1 || i > n) return core::fail("expected I/N, both from 1 on, I at most N, found \"" + text + "\"");
  return std::array<std::size_t, 2>{i - 1, n};
}

template <class T>
void add_limit(apps::CommandLine& line, const char* name, std::optional<T>& limit, double most,
               const std::string& help) {
  line.add(name, limit, help + ", instead of the suite's").in_range(0.0, most).accepted_by(apps::parse_finite);
}

void add_options(apps::CommandLine& line, Options& o) {
  line.add("SUITE", o.suite, "Suite JSON file (docs/guide/regress.md)").required();
  line.add("--out", o.out, "Folder for images and results, report.html and junit.xml").shows_default();
  const apps::Option workers =
      line.add("-j,--jobs", o.workers, "Worker processes").shows_default().in_range(1, kMostWorkers);
  const apps::Option mpi =
      line.add_flag("--mpi", o.mpi, "Under mpirun: rank 0 hands out tasks, each rank draws with one worker")
          .excludes(workers);
  const apps::Option shard =
      line.add("--shard", o.shard, "I/N: draw the I-th of N parts, for Slurm arrays and GNU parallel")
          .excludes(mpi)
          .accepted_by(parse_shard);
  line.add("--only", o.only, "Only tasks MODEL/VIEW that fit this pattern, with * and ?").one_value_each();
  const apps::Option resume = line.add_flag(
      "--resume", o.resume, "Keep results of the same tasks whose files did not change; errors are drawn again");
  const apps::Option merge =
      line.add("--merge", o.from,
               "Draw nothing: report on the results in --out, and in these folders, which are copied")
          .usage_text("[DIR …]")
          .takes(0, 10000)
          .excludes(workers)
          .excludes(mpi)
          .excludes(shard)
          .excludes(resume);
  line.add_flag("--accept", o.accept, "Make references of the images that fail or have none");
  line.add_flag("--list", o.list, "Print the names of the tasks, one a line, and draw nothing")
      .excludes(merge)
      .excludes(workers)
      .excludes(mpi)
      .excludes(resume);
  add_limit(line, "--max", o.limits.max, 255.0, "Largest difference of a channel, 0 to 255");
  add_limit(line, "--mean", o.limits.mean, 255.0, "Largest mean difference, 0 to 255");
  add_limit(line, "--flip", o.limits.flip, 1.0, "Largest mean FLIP, 0 to 1");
  add_limit(line, "--ids", o.limits.ids, 16384.0 * 16384.0,
            "Most pixels that may show another item, where ids have a limit");
  line.add("--timeout", o.timeout, "Seconds for a task, then its worker is killed; 0: any time")
      .shows_default()
      .in_range(0.0, 1e6);
  line.add("--silence", o.silence, "With --mpi: seconds after which a silent rank is given up")
      .shows_default()
      .needs(mpi)
      .in_range(1.0, 1e6);
  line.add("--images", o.images, "Images in report.html: failed, all or none")
      .shows_default()
      .one_of({"failed", "all", "none"});
  line.add("--html", o.html, "Write the page to FILE (default: report.html in --out)").usage_text("FILE");
  line.add("--junit", o.junit, "Write JUnit XML to FILE (default: junit.xml in --out)").usage_text("FILE");
  apps::add_renderer_option(line, o.renderer);
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json_file);
  line.add_flag("--quiet", o.quiet, "No progress bar and no table");
  line.add_flag("--worker", o.worker).hidden();  // how the tool starts its workers
  line.check([&o, merge]() -> core::Expected<void> {
    o.merge = merge.given();
    std::erase(o.from, "");  // what --merge without folders gives
    return {};
  });
}

/// Tasks of the shard that fit.
Tasks choose_tasks(const Options& o, const apps::Suite& suite) {
  Tasks fitting;
  for (std::size_t i = 0; i < suite.tasks.size(); ++i) {
    const auto fits = [&](const std::string& pattern) { return apps::fits(suite.tasks[i].name, pattern); };
    if (o.only.empty() || std::any_of(o.only.begin(), o.only.end(), fits)) fitting.push_back(i);
  }
  if (fitting.empty()) fail(o.suite + ": no task fits --only");
  if (o.shard.empty()) return fitting;
  const auto shard = parse_shard(o.shard).value();
  // Neighbours belong together: most are of one model, which is then read in one shard.
  const auto begin = [&](std::size_t part) {
    return fitting.begin() + std::ptrdiff_t(part * fitting.size() / shard[1]);
  };
  return Tasks(begin(shard[0]), begin(shard[0] + 1));
}

/// Those without a result that may be kept; old results of these are removed.
Tasks tasks_to_draw(const Options& o, const apps::Suite& suite, const apps::ResultFolder& results, const Tasks& tasks) {
  Tasks left;
  for (const std::size_t task : tasks) {
    const auto old = o.resume ? results.read(suite.tasks[task]) : std::nullopt;
    if (old && old->error.empty() && old->files_key == suite.files_key(suite.tasks[task])) continue;
    need(results.remove(suite.tasks[task]));
    left.push_back(task);
  }
  return left;
}

/// The program that runs, and arguments that make it a worker of this run.
std::vector<std::string> worker_command(const Options& o, int argc, char** argv) {
  const fs::path self = core::platform::program_file();
  std::vector<std::string> command = {self.empty() ? argv[0] : self.string(), o.suite, "--worker", "--out", o.out};
  for (const std::string option : {"--renderer", "--context-platform"})  // as they were given
    for (int i = 1; i < argc; ++i) {
      const std::string argument = argv[i];
      if (argument == option && i + 1 < argc) command.insert(command.end(), {option, argv[i + 1]});
      if (argument.rfind(option + "=", 0) == 0) command.push_back(argument);
    }
  return command;
}

core::Expected<int> serve(const Options& o, const apps::Suite& suite) {
  apps::TaskDrawer drawer(suite, apps::ResultFolder(o.out), o.renderer, o.platform);
  return apps::serve_tasks([&](std::size_t task, const std::string& key) -> core::Expected<void> {
    if (task >= suite.tasks.size() || suite.tasks[task].key != key)
      return core::fail(o.suite + ": was changed while its tasks were drawn");
    return drawer.run(suite.tasks[task]);
  });
}

/// Images of accepted tasks become references.
void copy_accepted(const apps::Suite& suite, const apps::ResultFolder& results,
                   const std::vector<apps::Outcome>& outcomes) {
  for (const apps::Outcome& o : outcomes) {
    if (o.status != apps::Status::kAccepted) continue;
    need(apps::copy_whole(results.image(*o.task), suite.reference(*o.task)));
    if (o.task->limits.ids) need(apps::copy_whole(results.ids(*o.task), suite.id_reference(*o.task)));
  }
}

std::string page_file(const Options& o) {
  return o.html.empty() ? (fs::path(o.out) / "report.html").string() : o.html;
}

void write_pages(const Options& o, const apps::Suite& suite, const apps::ResultFolder& results,
                 const std::vector<apps::Outcome>& outcomes) {
  using apps::ShownImages;
  const ShownImages shown = o.images == "all"    ? ShownImages::kAll
                            : o.images == "none" ? ShownImages::kNone
                                                 : ShownImages::kFailed;
  need(apps::write_text(page_file(o), need(html_report(suite, results, outcomes, shown, o.suite))));
  const std::string junit = o.junit.empty() ? (results.path() / "junit.xml").string() : o.junit;
  need(apps::write_text(junit, junit_xml(suite, outcomes)));
}

void print(const Options& o, const std::vector<apps::Outcome>& outcomes) {
  if (o.quiet) return;
  std::FILE* out = apps::table_stream(o.json_file);
  for (const apps::Outcome& outcome : outcomes)
    if (outcome.status != apps::Status::kPassed)
      std::fprintf(out, "%-8s %s: %s\n", name_of(outcome.status).data(), outcome.task->name.c_str(),
                   outcome.reason.c_str());
  std::fprintf(out, "%s\n", summary(outcomes).c_str());
  if (o.shard.empty() && !all_good(outcomes)) std::fprintf(out, "page: %s\n", page_file(o).c_str());
  const auto failed = [](const apps::Outcome& outcome) { return outcome.status == apps::Status::kFailed; };
  if (std::any_of(outcomes.begin(), outcomes.end(), failed))
    std::fprintf(out, "to take what failed as references, if it is right: the same with --resume --accept\n");
}

/// A shard writes no pages: --merge makes those of all shards.
int report(const Options& o, const apps::Suite& suite, const apps::ResultFolder& results, const Tasks& tasks) {
  auto outcomes = apps::outcomes(suite, results, tasks);
  if (o.accept)
    for (apps::Outcome& outcome : outcomes)
      if (outcome.status == apps::Status::kFailed) outcome.status = apps::Status::kAccepted;
  if (o.shard.empty()) write_pages(o, suite, results, outcomes);  // with the references as they were
  copy_accepted(suite, results, outcomes);
  need(apps::write_json(o.json_file, json::sorted(to_json(suite, outcomes))));
  print(o, outcomes);
  return all_good(outcomes) ? apps::kExitOk : apps::kExitFailure;
}

/// Tasks that are left to draw; with --merge none, and the results are taken from other folders.
Tasks begin_run(const Options& o, const apps::Suite& suite, const apps::ResultFolder& results, const Tasks& tasks) {
  need(apps::make_directory(o.out));
  if (!o.merge) return tasks_to_draw(o, suite, results, tasks);
  for (const std::string& folder : o.from) {
    std::error_code none;
    if (!fs::is_directory(folder, none)) fail(folder + ": is no folder");
    for (const std::size_t task : tasks) need(results.take(suite.tasks[task], apps::ResultFolder(folder)));
  }
  return {};
}

/// On rank 0 and without MPI.
core::Expected<void> draw(const Options& o, const apps::Suite& suite, const apps::ResultFolder& results,
                          const Tasks& left, std::vector<apps::Worker>& workers,
                          [[maybe_unused]] std::optional<apps::MpiSession>& session) {
  std::optional<apps::Progress> bar;
  if (!o.quiet) bar.emplace("drawing", left.size());
  apps::Farm farm(suite, results, left, [&](std::size_t finished) {
    if (bar) bar->advance(finished);
  });
#if SIGHTLINE_HAS_MPI
  if (o.mpi) return run_mpi_farm(farm, workers.front(), o.silence, *session);
#endif
  return farm.run(workers);
}

/// `session`: gets that of --mpi.
core::Expected<int> regress(const Options& o, const std::vector<std::string>& worker_command,
                            std::optional<apps::MpiSession>& session) {
  if (o.mpi) session.emplace(need(apps::MpiSession::begin()));
  const auto agreed = [&](const auto& body) {
    auto own = attempt(body);
    return session ? session->agreed(std::move(own)) : own;
  };
  auto suite = agreed([&] { return need(apps::read_suite(o.suite, o.limits)); });
  if (!suite) return tl::unexpected(suite.error());
  suite->drawn_by = std::string(name_of(o.renderer)) + " " + std::to_string(int(o.platform));
  if (o.worker) return serve(o, *suite);
  const auto tasks = agreed([&] { return choose_tasks(o, *suite); });
  if (!tasks) return tl::unexpected(tasks.error());
  if (o.list) {
    for (const std::size_t task : *tasks) std::printf("%s\n", suite->tasks[task].name.c_str());
    return apps::kExitOk;
  }
  const apps::ResultFolder results(o.out);
  const bool leads = !session || session->rank() == 0;
  const auto left = agreed([&] { return leads ? begin_run(o, *suite, results, *tasks) : Tasks(); });
  if (!left) return tl::unexpected(left.error());
  core::platform::survive_broken_pipes();  // of workers that died
  std::vector<apps::Worker> workers;
  const std::size_t count = std::clamp<std::size_t>(left->size(), 1, std::size_t(o.workers));
  for (std::size_t i = 0; i < count; ++i) workers.emplace_back(worker_command, o.timeout);
#if SIGHTLINE_HAS_MPI
  if (!leads) {
    need(serve_mpi_farm(*suite, workers.front()));
    return apps::kExitOk;
  }
#endif
  need(draw(o, *suite, results, *left, workers, session));
  return report(o, *suite, results, *tasks);
}

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line("Images of many views of many models against references, by many processes",
                         "sightline-regress",
                         "  sightline-regress suite.json --accept          # the first references\n"
                         "  sightline-regress suite.json -j 4 --out results\n"
                         "  sightline-regress suite.json --only 'plant/*' --max 8 --images all\n"
                         "  sightline-regress suite.json --resume --accept # takes what the last run drew\n"
                         "  mpirun --enable-recovery -np 8 sightline-regress suite.json --mpi\n"
                         "  seq 4 | parallel sightline-regress suite.json --out results --shard {}/4\n"
                         "  sightline-regress suite.json --out results --merge");
  Options options;
  add_options(line, options);
  std::optional<apps::MpiSession> session;
  const int code = line.run(argc, argv, [&] { return regress(options, worker_command(options, argc, argv), session); });
  if (session) session->end_if_ranks_lost(code);
  return code;
}
