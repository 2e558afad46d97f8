// sightline-bench hybrid as a user runs it: every method sees the same, and what it measures hangs together.
#include "sightline/tests/apps/render_test.h"

namespace sightline::tests::bench_hybrid_test {
namespace {

using BenchHybrid = RenderTest;

const Args kQuick = {"hybrid", "--frames", "6", "--passes", "1", "--block", "4", "--warm-up", "1", "--size", "32x24"};

Args quick(std::initializer_list<const char*> more) {
  Args args = kQuick;
  args.insert(args.end(), more.begin(), more.end());
  return args;
}

TEST_F(BenchHybrid, FliesGeneratedScenesWithEveryMethod) {
  const std::string results = path("figures");
  const Json json = run_json("bench", quick({"--only", "P-40,aircraft", "--scale", "0.015", "--csv", results.c_str()}));
  ASSERT_EQ(json["runs"].size(), 4u);  // off and on
  for (const Json& run : json["runs"]) {
    SCOPED_TRACE(run["model"].get<std::string>() + " " + run["rendering"].get<std::string>());
    ASSERT_EQ(run["modes"].size(), 3u);
    EXPECT_EQ(run["modes"][1]["gpu_share"], 1.0);
    EXPECT_EQ(run["modes"][2]["culler"], run["model"] == "aircraft" ? "hybrid" : "cpu");
    for (const Json& mode : run["modes"]) {
      EXPECT_NEAR(mode["visible"].get<double>(), run["modes"][0]["visible"].get<double>(), 1.0);
      EXPECT_GT(mode["visible"], 100.0);
      ASSERT_EQ(mode["costs_ms"].size(), 6u);
      for (const Json& ms : mode["costs_ms"]) EXPECT_GT(ms, 0.0);
      EXPECT_LE(mode["min_fps"], mode["mean_fps"]);
      EXPECT_LE(mode["mean_fps"], mode["max_fps"]);
      EXPECT_NEAR(mode["mean_fps"].get<double>() * mode["mean_ms"].get<double>(), 1e3, 1e-6);
    }
    EXPECT_EQ(run["modes"][0]["to_cpu"], 1.0);
  }
  for (const char* file :
       {"P-40_off_6_1.svg", "P-40_off_6_5.svg", "P-40_on_6_7.svg", "aircraft_on_trace.csv", "aircraft_off_trace.csv"})
    EXPECT_GT(read_bytes(fs::path(results) / file).size(), 100u) << file;
  const Outcome controller = run("replay", {"--controller-only", results + "/aircraft_on_trace.csv"});
  EXPECT_EQ(controller.code, 0) << controller;
}

TEST_F(BenchHybrid, FliesModelsAndLeavesTheGpuOutOfSmallOnes) {
  const Json json = run_json("bench", quick({plant(3000).c_str(), "--rendering", "on"}));
  ASSERT_EQ(json["runs"].size(), 1u);
  EXPECT_EQ(json["runs"][0]["model"], "plant-3000-1");
  EXPECT_EQ(json["runs"][0]["modes"][2]["culler"], "cpu");
}

/// The number of GL calls is the CPU's work in a unit that no load changes.
TEST_F(BenchHybrid, SubmittingTakesNoMoreCallsForMoreItems) {
  const Json rows = run_json("bench", quick({"--submission", "3000,20000"}))["submission"];
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_GT(rows[1]["visible"].get<double>(), 3.0 * rows[0]["visible"].get<double>());
  EXPECT_LT(rows[1]["gl_calls"].get<double>(), 1.5 * rows[0]["gl_calls"].get<double>());
}

TEST_F(BenchHybrid, RefusesWhatMakesNoSense) {
  expect_usage_error("bench", {"hybrid", "--only", "P-39"}, "P-39");
  expect_usage_error("bench", {"hybrid", "--scale", "nan"}, "--scale");
  expect_failure("bench", {"hybrid", path("none.rvm")}, "none.rvm", true);
  expect_failure("bench", {"hybrid", "--csv", unwritable("figures")}, "cannot be made", true);
}

}  // namespace
}  // namespace sightline::tests::bench_hybrid_test
