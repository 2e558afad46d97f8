// sightline-regress: the same images and verdicts however the work is shared out, and whoever dies meanwhile.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <map>
#include <set>
#include <thread>

#include "sightline/core/internal/platform/files.h"
#include "sightline/tests/apps/mpi_launcher.h"
#include "sightline/tests/apps/render_test.h"
#include "sightline/tests/support/places.h"

namespace sightline::tests::regress_test {
namespace {

using namespace std::chrono_literals;

/// Bytes of all images below a folder, by their names in it.
std::map<std::string, std::string> images_in(const fs::path& folder) {
  std::map<std::string, std::string> out;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".png") out[fs::relative(entry.path(), folder).string()] = read_bytes(entry.path());
  return out;
}

std::vector<pid_t> children_of(pid_t pid) {
  std::istringstream in(read_bytes("/proc/" + std::to_string(pid) + "/task/" + std::to_string(pid) + "/children"));
  std::vector<pid_t> out;
  for (pid_t child; in >> child;) out.push_back(child);
  return out;
}

/// The tasks of Regress::suite if its flights have so many frames.
constexpr int tasks_of(int frames) {
  return 2 * (3 + frames);
}

class Regress : public RenderTest {
 protected:
  void SetUp() override {
    RenderTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    fs::rename(plant(1000, 1), path("a.rvm"));
    fs::rename(plant(2000, 2), path("b.rvm"));
    write("flight.json", R"({"keys":[{"t":0,"eye":[-30,-12,6],"target":[5,2,3],"fovy_deg":60},
                                     {"t":4,"eye":[10,-12,6],"target":[5,2,3]}],"near":0.1})");
    suite = write_suite("200x120", 3);
  }

  std::string write_suite(const std::string& size, int frames) const {
    const std::string views = R"([{"name":"whole"},{"name":"smooth","samples":4,"limits":{"ids":null}},
                                  {"name":"standard","samples":2,"looks":"standard"},
                                  {"name":"flight","path":"flight.json","frames":)" +
                              std::to_string(frames) + "}]";
    return write("suite.json", R"({"size":")" + size + R"(","limits":{"max":0,"ids":0},"models":[
        {"name":"a","files":["a.rvm"],"views":)" +
                                   views + R"(},{"name":"b","files":["b.rvm"],"views":)" + views + "}]}");
  }

  Args command(const std::string& out, const Args& more = {}) const {
    Args args = {suite, "--out", path(out)};
    args.insert(args.end(), more.begin(), more.end());
    return args;
  }
  /// Draws, with JSON, and expects the exit code.
  Json regress(const std::string& out, int code, const Args& more = {}) const {
    Args args = command(out, more);
    args.insert(args.end(), {"--json", "-"});
    return parsed(run("regress", args), code);
  }
  static Json parsed(const Outcome& outcome, int code) {
    EXPECT_EQ(outcome.code, code) << outcome;
    const Json json = json::parse(outcome.out).value_or(Json());
    EXPECT_TRUE(json.is_object()) << outcome;
    return json.is_object() ? json : Json{{"passed", -1}};
  }
  void make_references() const { EXPECT_EQ(regress("first", 0, {"--accept"})["accepted"], count); }

  static void expect_same(const Json& one, const Json& other) {
    Json a = one, b = other;
    for (Json* json : {&a, &b})
      for (Json& task : (*json)["tasks"]) task.erase("seconds");
    EXPECT_EQ(a, b);
  }

#if __has_include(<spawn.h>)
  /// Kills what `victim` picks of a run, so many processes, unless the run ends before; then waits for its end.
  template <class Victim>
  Outcome run_and_kill(const Child& child, std::size_t times, const Victim& victim) const {
    std::set<pid_t> killed;
    while (killed.size() < times) {
      std::this_thread::sleep_for(2ms);
      siginfo_t info{};
      if (waitid(P_PID, id_t(child.pid), &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid != 0) break;
      const pid_t pid = victim(children_of(child.pid));
      // One that was killed stays a child until its parent asks for it.
      if (pid <= 0 || killed.contains(pid) || kill(pid, SIGKILL) != 0) continue;
      killed.insert(pid);
      std::this_thread::sleep_for(30ms);
    }
    return wait_for(child);
  }
#endif

  /// A script of examples/regress, which finds sightline-regress.
  Outcome run_script(const std::string& script, const Args& args, const Args& environment = {}) const {
    Args all = {"PATH=" + in_bin("").string() + ":/usr/local/bin:/usr/bin:/bin"};
    all.insert(all.end(), environment.begin(), environment.end());
    all.insert(all.end(), {"bash", in_checkout("examples/regress/" + script).string()});
    all.insert(all.end(), args.begin(), args.end());
    return run_program("env", all);
  }

  std::string suite;
  static constexpr int count = tasks_of(3);
};

TEST_F(Regress, ImagesAreTheSameForAnyNumberOfWorkersAndShards) {
  make_references();
  const auto reference = images_in(path("first"));
  ASSERT_EQ(reference.size(), 22u);  // ten with ids
  const Json one = regress("one", 0);
  EXPECT_EQ(one["passed"], count);
  EXPECT_EQ(images_in(path("one")), reference);
  for (const char* jobs : {"2", "4"}) {
    SCOPED_TRACE(jobs);
    expect_same(regress(jobs, 0, {"-j", jobs}), one);
    EXPECT_EQ(images_in(path(jobs)), reference);
  }
  // In folders of their own, in any order, and merged.
  Args merge = {"--merge"};
  for (const char* shard : {"3/3", "1/3", "2/3"}) {
    merge.push_back(path(std::string("shard") + shard[0]));
    EXPECT_EQ(run("regress", command(std::string("shard") + shard[0], {"--shard", shard})).code, 0);
    EXPECT_FALSE(fs::exists(path(std::string("shard") + shard[0] + "/report.html")));
  }
  expect_same(regress("merged", 0, merge), one);
  EXPECT_EQ(images_in(path("merged")), reference);
  // Tasks alone, in reverse order, into one folder.
  const Outcome list = run("regress", {suite, "--list"});
  std::vector<std::string> names;
  std::istringstream in(list.out);
  for (std::string name; in >> name;) names.insert(names.begin(), name);
  ASSERT_EQ(names.size(), std::size_t(count)) << list;
  for (const std::string& name : names) EXPECT_EQ(regress("alone", 0, {"--only", name})["count"], 1);
  expect_same(regress("alone", 0, {"--merge"}), one);
  EXPECT_EQ(images_in(path("alone")), reference);
}

/// The parts of a text between `begin` and `end`.
std::vector<std::string> between(const std::string& text, const std::string& begin, const std::string& end) {
  std::vector<std::string> parts;
  for (std::size_t at = text.find(begin); at != std::string::npos; at = text.find(begin, at)) {
    at += begin.size();
    parts.push_back(text.substr(at, text.find(end, at) - at));
  }
  return parts;
}

/// A label around each image chooses the next image's button, and the last one's the first. Buttons of a task have a
/// name of their own, and the first is chosen.
void expect_flips(const std::string& page) {
  std::set<std::string> names;
  for (const std::string& flip : between(page, "<div class=\"flip\">", "</figure>")) {
    const std::string frames = flip.substr(flip.find("class=\"frames\""));
    std::vector<std::string> buttons = between(flip, " id=\"", "\"");
    EXPECT_EQ(between(flip, "checked=\"", "\"").size(), 1u);
    std::rotate(buttons.begin(), buttons.begin() + 1, buttons.end());
    EXPECT_EQ(between(frames, "<label for=\"", "\""), buttons);
    EXPECT_EQ(between(frames, "<img ", "/>").size(), buttons.size());
    EXPECT_TRUE(names.insert(between(flip, " name=\"", "\"").at(0)).second);
  }
  EXPECT_EQ(names.size(), 6u);
}

TEST_F(Regress, AChangedModelFailsWithImagesOfIt) {
  make_references();
  fs::rename(plant(2000, 3), path("b.rvm"));
  const Json json = regress("out", 1, {"-j", "2"});
  EXPECT_EQ(json["passed"], count / 2);
  EXPECT_EQ(json["failed"], count / 2);
  for (const Json& task : json["tasks"]) {
    EXPECT_EQ(task["status"], task["name"].get<std::string>()[0] == 'a' ? "passed" : "failed") << task;
    EXPECT_EQ(task["reason"] == "", task["status"] == "passed") << task;
  }
  const std::string page = read_bytes(path("out/report.html")), junit = read_bytes(path("out/junit.xml"));
  const auto occurrences = [](const std::string& text, const std::string& of) {
    int found = 0;
    for (std::size_t at = text.find(of); at != std::string::npos; at = text.find(of, at + 1)) ++found;
    return found;
  };
  EXPECT_EQ(occurrences(page, "<img "), 3 * count / 2 + 5);  // five with an image of ids
  EXPECT_EQ(occurrences(page, "<section "), 1 + count / 2);
  EXPECT_EQ(occurrences(page, "\u2713 passed</span>"), count / 2) << "in the table";
  EXPECT_EQ(occurrences(page, "\u2717 failed</span>"), 3 * count / 2 + 2) << "there, above and at the images; of all";
  expect_flips(page);
  EXPECT_EQ(occurrences(junit, "<failure "), count / 2);
  EXPECT_EQ(occurrences(junit, "<testcase "), count);
  EXPECT_EQ(regress("out", 0, {"--resume", "--max", "255", "--ids", "100000000"})["passed"], count);
  // The new images become the references, without drawing any again.
  const auto time = fs::last_write_time(path("out/b/whole/result.json"));
  EXPECT_EQ(regress("out", 0, {"--resume", "--accept"})["accepted"], count / 2);
  EXPECT_EQ(fs::last_write_time(path("out/b/whole/result.json")), time);
  EXPECT_EQ(regress("out", 0)["passed"], count);
}

TEST_F(Regress, ResumeDrawsOnlyWhatIsLeft) {
  make_references();
  ASSERT_EQ(regress("out", 0)["passed"], count);
  const auto time = [&](const char* task) {
    std::error_code missing;
    return core::platform::write_time(path("out/" + std::string(task) + "/result.json"), missing);
  };
  const auto kept = time("a/whole"), redone = time("b/whole");
  fs::remove(path("out/a/smooth/result.json"));
  write("out/a/flight-00001/result.json", "{\"key\":");
  fs::last_write_time(path("b.rvm"), fs::last_write_time(path("b.rvm")) + 1h);
  EXPECT_EQ(regress("out", 1, {"--merge"})["missing"], 2);
  EXPECT_EQ(regress("out", 0, {"--resume"})["passed"], count);
  EXPECT_EQ(time("a/whole"), kept);
  EXPECT_NE(time("b/whole"), redone);
  // By rays it is drawn again, once.
  (void)run("regress", command("out", {"--resume", "--renderer", "rays"}));
  const auto by_rays = time("a/whole");
  EXPECT_NE(by_rays, kept);
  (void)run("regress", command("out", {"--resume", "--renderer", "rays"}));
  EXPECT_EQ(time("a/whole"), by_rays);
}

TEST_F(Regress, WhatCannotBeDrawnIsAnErrorOfItsTasksAlone) {
  make_references();
  write("b.rvm", "this is no model\n");
  Json json = regress("out", 1);
  EXPECT_EQ(json["passed"], count / 2);
  EXPECT_EQ(json["error"], count / 2);
  EXPECT_NE(json["tasks"][6]["reason"].get<std::string>().find("b.rvm"), std::string::npos);
  EXPECT_EQ(regress("out", 1, {"--accept"})["error"], count / 2);
  fs::remove(path("references/a/whole.png"));
  write("references/a/smooth.png", "this is no image\n");
  write("references/a/flight-00000.ids.png", read_bytes(path("first/b/whole/image.png")));
  json = regress("out", 1, {"--only", "a/*"});
  EXPECT_EQ(json["failed"], 3);
  EXPECT_NE(json["tasks"][0]["reason"].get<std::string>().find("no reference"), std::string::npos);
  EXPECT_NE(json["tasks"][1]["reason"].get<std::string>().find("smooth.png"), std::string::npos);
  // An image of another size.
  fs::copy_file(path("references/a/whole.ids.png"), path("references/a/whole.png"));
  write_suite("100x60", 3);
  json = regress("out", 1, {"--only", "a/whole"});
  EXPECT_NE(json["tasks"][0]["reason"].get<std::string>().find("200x120"), std::string::npos) << json;
}

/// Views are coloured one by one, whichever was drawn before.
TEST_F(Regress, ColoursByAttributes) {
  suite = write("coloured.json", R"({"size":"96x64","models":[{"name":"a","files":["a.rvm"],"views":[{"name":"plain"},
      {"name":"kinds","colour_by":"@kind"},{"name":"again"},{"name":"none","colour_by":"NO SUCH KEY"}]}]})");
  const Json json = regress("out", 1, {"--accept"});
  EXPECT_EQ(json["accepted"], 3);
  EXPECT_NE(json["tasks"][3]["reason"].get<std::string>().find("NO SUCH KEY"), std::string::npos) << json;
  const std::string plain = read_bytes(path("out/a/plain/image.png"));
  EXPECT_EQ(plain, read_bytes(path("out/a/again/image.png")));
  EXPECT_NE(plain, read_bytes(path("out/a/kinds/image.png")));
}

TEST_F(Regress, SectionsThatLeaveNothingAreErrors) {
  const auto suite_of = [&](const std::string& more) {
    return write("cut.json", R"({"size":"64x36","models":[{"name":"a","files":["a.rvm"],"views":[{"name":"cut","view":
        {"eye":[-30,-12,6],"target":[5,2,3],"fovy_deg":60,"near":0.1,"sections":[{"n":[0,0,1],"d":-3000}]})" +
                                 more + "}]}]}");
  };
  suite = suite_of("");
  const Json refused = regress("refused", 1, {"--accept"});
  EXPECT_EQ(refused["error"], 1);
  EXPECT_NE(refused["tasks"][0]["reason"].get<std::string>().find("the sections leave nothing"), std::string::npos);
  suite = suite_of(R"(,"allow_empty":true)");
  EXPECT_EQ(regress("allowed", 0, {"--accept"})["accepted"], 1);
}

TEST_F(Regress, RefusesBadUsage) {
  expect_failure("regress", {path("missing.json")}, "missing.json");
  expect_failure("regress", {write("broken.json", "{")}, "broken.json");
  expect_failure("regress", {suite, "--only", "nothing"}, "--only");
  expect_failure("regress", {suite, "--out", unwritable("out")}, "out");
  expect_failure("regress", {suite, "--out", path("out"), "--merge", path("missing")}, "missing");
  for (const char* bad : {"0/3", "4/3", "1", "1/", "x/y", "1/0", "-1/2"})
    expect_usage_error("regress", {suite, "--shard", bad}, "--shard");
  for (const char* bad : {"0", "257", "x"}) expect_usage_error("regress", {suite, "-j", bad}, "-j");
  expect_usage_error("regress", {suite, "--mpi", "-j", "2"}, "--mpi");
  expect_usage_error("regress", {suite, "--merge", "--resume"}, "--merge");
  expect_usage_error("regress", {suite, "--max", "nan"}, "--max");
  expect_usage_error("regress", {suite, "--silence", "5"}, "--silence");
}

#if __has_include(<spawn.h>)
TEST_F(Regress, AKilledWorkersTaskIsDoneByAnother) {
  suite = write_suite("1000x600", 4);
  EXPECT_EQ(run("regress", command("first", {"--accept"})).code, 0);
  const Child child = start_program(program_of("regress"), command("out", {"-j", "2", "--json", path("out.json")}));
  ASSERT_GT(child.pid, 0);
  const Outcome outcome =
      run_and_kill(child, 1, [](const auto& workers) { return workers.empty() ? 0 : workers.back(); });
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_EQ(outcome.out, "14 images: 14 passed\n") << outcome;
  EXPECT_EQ(images_in(path("out")), images_in(path("first")));
}

TEST_F(Regress, ATaskThatKillsTwoWorkersFailsWithTheReason) {
  suite = write_suite("2000x2000", 1);
  const Args args = command("out", {"--only", "b/whole", "--json", path("out.json")});
  Outcome outcome;
  const auto reason = [&] {
    const Json json = json::parse(read_bytes(path("out.json"))).value_or(Json());
    return json.is_object() ? json["tasks"][0]["reason"].get<std::string>() : std::string();
  };
  // A worker may be done before this process comes to kill it: then the run is tried again.
  for (int tries = 0; tries < 5 && reason().find("signal 9") == std::string::npos; ++tries) {
    fs::remove_all(path("out"));
    const Child child = start_program(program_of("regress"), args);
    ASSERT_GT(child.pid, 0);
    outcome = run_and_kill(child, 2, [](const auto& workers) { return workers.empty() ? 0 : workers.back(); });
  }
  EXPECT_EQ(outcome.code, 1) << outcome;
  const Json json = json::parse(read_bytes(path("out.json"))).value_or(Json());
  ASSERT_TRUE(json.is_object()) << outcome;
  EXPECT_EQ(json["error"], 1) << json;
  EXPECT_NE(json["tasks"][0]["reason"].get<std::string>().find("signal 9"), std::string::npos) << json;
  EXPECT_NE(read_bytes(path("out/junit.xml")).find("<error type=\"error\""), std::string::npos);
}
#endif

TEST_F(Regress, ATaskThatTakesTooLongIsEnded) {
  suite = write_suite("8000x8000", 1);
  const Json json = regress("out", 1, {"--only", "b/whole", "--timeout", "0.05"});
  EXPECT_EQ(json["error"], 1);
  EXPECT_NE(json["tasks"][0]["reason"].get<std::string>().find("took more than 0.05 s"), std::string::npos) << json;
}

TEST_F(Regress, TheExampleSuitePasses) {
  const std::string example = in_checkout("examples/regress/suite.json").string();
  const Outcome outcome = run("regress", {example, "--out", path("out"), "-j", "2"});
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_EQ(outcome.out, "7 images: 7 passed\n");
}

TEST_F(Regress, ShardsOfGnuParallelAndOfSlurm) {
  make_references();
  Outcome outcome = run_script("parallel.sh", {suite, path("parallel"), "3"});
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_EQ(outcome.out, "12 images: 12 passed\n") << outcome;
  EXPECT_EQ(images_in(path("parallel")), images_in(path("first")));
  // An array job of two, the second one after its node died.
  for (const char* task : {"1", "2"}) {
    outcome = run_script("shards.slurm", {suite, path("slurm")},
                         {"SLURM_ARRAY_TASK_COUNT=2", std::string("SLURM_ARRAY_TASK_ID=") + task});
    EXPECT_EQ(outcome.code, 0) << outcome;
    if (task[0] == '1') {
      EXPECT_EQ(regress("slurm", 1, {"--merge"})["missing"], count / 2);
    }
  }
  EXPECT_EQ(regress("slurm", 0, {"--merge"})["passed"], count);
  fs::remove(path("references/b/whole.png"));
  outcome = run_script("parallel.sh", {suite, path("parallel"), "2"});
  EXPECT_EQ(outcome.code, 1) << outcome;
}

#if SIGHTLINE_HAS_MPI

class RegressMpi : public Regress {
 protected:
  void SetUp() override {
    Regress::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    if (run_program("mpirun", {"--version"}).code != 0) GTEST_SKIP() << "no mpirun (openmpi-bin)";
  }
  Args mpi_command(const std::string& out, const Args& launcher, const Args& more = {}) const {
    Args args = mpirun_here();
    args.insert(args.end(), launcher.begin(), launcher.end());
    args.push_back(program_of("regress"));
    const Args rest = command(out, {"--mpi", "--json", path(out + ".json")});
    args.insert(args.end(), rest.begin(), rest.end());
    args.insert(args.end(), more.begin(), more.end());
    return args;
  }
  Json results(const std::string& out) const {
    const Json json = json::parse(read_bytes(path(out + ".json"))).value_or(Json());
    EXPECT_TRUE(json.is_object());
    return json.is_object() ? json : Json{{"passed", -1}};
  }
};

TEST_F(RegressMpi, RanksDrawWhatOneProcessDraws) {
  make_references();
  const Json one = regress("one", 0);
  for (const char* ranks : {"1", "2", "4"}) {
    SCOPED_TRACE(ranks);
    const Outcome outcome = run_program("env", mpi_command(ranks, {"-np", ranks}));
    EXPECT_EQ(outcome.code, 0) << outcome;
    expect_same(results(ranks), one);
    EXPECT_EQ(images_in(path(ranks)), images_in(path("first")));
  }
  fs::remove(path("references/b/whole.png"));
  EXPECT_EQ(run_program("env", mpi_command("2", {"-np", "2"})).code, 1);
}

TEST_F(RegressMpi, AnErrorIsToldOnceAndEndsAll) {
  const auto expect_one = [&](const Args& command, const std::string& named) {
    const Outcome outcome = run_program("env", command);
    EXPECT_NE(outcome.code, 0) << outcome;
    const auto lines = outcome.error_lines();
    const auto is_ours = [](const std::string& line) { return line.rfind("sightline-regress: ", 0) == 0; };
    EXPECT_EQ(std::count_if(lines.begin(), lines.end(), is_ours), 1) << outcome;
    EXPECT_NE(outcome.err.find(named), std::string::npos) << outcome;
  };
  expect_one(mpi_command("out", {"-np", "3"}, {"--only", "nothing"}), "--only");
  write("out-file", "");
  expect_one(mpi_command("out-file", {"-np", "3"}), "out-file");
  suite = write("broken.json", "{");
  expect_one(mpi_command("out", {"-np", "3"}), "broken.json");
}

/// Ranks are the children of mpirun, which env has become; each has one worker.
TEST_F(RegressMpi, AKilledWorkerOfARankIsReplaced) {
  suite = write_suite("1000x600", 4);
  EXPECT_EQ(run("regress", command("first", {"--accept"})).code, 0);
  const Child child = start_program("env", mpi_command("out", {"-np", "3"}));
  const Outcome outcome = run_and_kill(child, 1, [](const auto& ranks) {
    if (ranks.size() < 3) return 0;
    const auto workers = children_of(ranks[1]);
    return workers.empty() ? 0 : workers[0];
  });
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_EQ(results("out")["passed"], tasks_of(4)) << outcome;
  EXPECT_EQ(images_in(path("out")), images_in(path("first")));
}

TEST_F(RegressMpi, AKilledRanksTasksAreDoneByOthers) {
  suite = write_suite("1000x600", 4);
  EXPECT_EQ(run("regress", command("first", {"--accept"})).code, 0);
  Outcome outcome;
  const auto missed = [&] { return outcome.err.find("rank 2 is silent") != std::string::npos; };
  // Killed between its tasks or after the last one, a rank is not missed: then the run is tried again.
  for (int tries = 0; tries < 5 && !missed(); ++tries) {
    fs::remove_all(path("out"));
    const Child child = start_program("env", mpi_command("out", {"--enable-recovery", "-np", "3"}, {"--silence", "2"}));
    outcome = run_and_kill(
        child, 1, [](const auto& ranks) { return ranks.size() < 3 || children_of(ranks[2]).empty() ? 0 : ranks[2]; });
    EXPECT_EQ(results("out")["passed"], tasks_of(4)) << outcome;
    EXPECT_EQ(images_in(path("out")), images_in(path("first")));
  }
  EXPECT_TRUE(missed()) << outcome;
  EXPECT_EQ(regress("out", 0, {"--merge"})["passed"], tasks_of(4));
}

/// Without --enable-recovery mpirun ends all ranks; what they drew stays. A rank that mpirun has not ended yet
/// draws on, at worst all that is left: then the run is tried again.
TEST_F(RegressMpi, ARunThatMpirunEndedIsResumed) {
  suite = write_suite("1000x600", 20);
  EXPECT_EQ(run("regress", command("first", {"--accept"})).code, 0);
  const int tasks = tasks_of(20);
  int missing = 0;
  for (int tries = 0; tries < 5 && missing == 0; ++tries) {
    fs::remove_all(path("out"));
    const Child child = start_program("env", mpi_command("out", {"-np", "2"}));
    run_and_kill(child, 1, [&](const auto& ranks) {
      return ranks.size() < 2 || !fs::exists(path("out/a/whole/result.json")) ? 0 : ranks[1];
    });
    const Outcome merge = run("regress", command("out", {"--merge", "--json", "-"}));
    const Json left = parsed(merge, merge.code);
    missing = left["missing"].get<int>();
    EXPECT_EQ(left["passed"].get<int>() + missing, tasks) << merge;
    EXPECT_EQ(merge.code, missing == 0 ? 0 : 1) << merge;
  }
  EXPECT_GT(missing, 0);
  EXPECT_EQ(regress("out", 0, {"--resume"})["passed"], tasks);
  EXPECT_EQ(images_in(path("out")), images_in(path("first")));
}

#endif

}  // namespace
}  // namespace sightline::tests::regress_test
