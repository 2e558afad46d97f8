// The controller over traces: the simulation itself, the CSV, and the regret that it promises.
#include "sightline/apps/common/controller_trace.h"

#include <cmath>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "sightline/apps/bench/synthetic_traces.h"
#include "sightline/tests/support/places.h"

namespace sightline::tests::controller_trace_test {
namespace {

constexpr const char* kHeader = "frame,visible,cpu_cull_ms,cpu_frame_ms,gpu_cull_ms,gpu_frame_ms\n";

TEST(ControllerTrace, ReadsColumnsInAnyOrder) {
  const auto trace = apps::parse_controller_trace(
      "tested, gpu_frame_ms,extra,frame,visible,cpu_cull_ms,cpu_frame_ms,gpu_cull_ms\r\n"
      "7,6,x,41,5,1,2,3\r\n\n8,nan,y,42,0,1e-3,2,3\r\n",
      "t.csv");
  ASSERT_TRUE(trace) << trace.error().message;
  ASSERT_EQ(trace->size(), 2u);
  EXPECT_EQ((*trace)[0].gpu_frame_ms, 6.0);
  EXPECT_EQ((*trace)[0].visible, 5.0);
  EXPECT_TRUE(std::isnan((*trace)[1].gpu_frame_ms));
  EXPECT_EQ((*trace)[1].cpu_cull_ms, 1e-3);
}

TEST(ControllerTrace, WritesWhatItReads) {
  auto trace = bench::synthetic_traces()[4].frames;
  trace[3].visible = 12345678.0;
  trace[4].gpu_cull_ms = std::nan("");
  const std::string csv = apps::controller_trace_csv(trace);
  const auto again = apps::parse_controller_trace(csv, "t.csv");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(apps::controller_trace_csv(*again), csv);
}

TEST(ControllerTrace, NamesTheLineOfWhatIsWrong) {
  const std::string header = kHeader;
  const std::pair<std::string, std::string> cases[] = {
      {"", "t.csv:1: no column frame"},
      {"frame,visible,cpu_cull_ms,cpu_frame_ms,gpu_cull_ms\n1,1,1,1,1\n", "t.csv:1: no column gpu_frame_ms"},
      {"frame," + header, "t.csv:1: column frame twice"},
      {header, "no frames"},
      {header + "0,1,1,1,1\n", "t.csv:2: 6 fields expected, found 5"},
      {header + "0,1,1,1,1,1\n1,1,1,1,1,1,1\n", "t.csv:3: 6 fields expected, found 7"},
      {header + "0,1,one,1,1,1\n", "t.csv:2: cpu_cull_ms: 'one' is no number"},
      {header + "0,1,1ms,1,1,1\n", "t.csv:2: cpu_cull_ms: '1ms' is no number"},
      {header + "0,1,,1,1,1\n", "t.csv:2: cpu_cull_ms: '' is no number"},
      {header + "0,1,1,0,1,1\n", "t.csv:2: cpu_frame_ms: '0' is no time > 0"},
      {header + "0,1,1,1,-2,1\n", "t.csv:2: gpu_cull_ms: '-2' is no time > 0"},
      {header + "0,1.7976931348623157e308,1,1,1,1\n", "visible: '1.7976931348623157e308' is no count >= 0 and <= 1e15"},
      {header + "0,1,1,1,1,inf\n", "t.csv:2: gpu_frame_ms: 'inf' is no time > 0"},
      {header + "0,-1,1,1,1,1\n", "t.csv:2: visible: '-1' is no count"},
      {header + "0.5,1,1,1,1,1\n", "t.csv:2: frame: '0.5' is no frame number"},
      {header + "nan,1,1,1,1,1\n", "t.csv:2: frame: 'nan' is no frame number"},
      {header + "0,1,1,1,1,1\n\n2,1,1,1,1,1\n", "t.csv:4: frame: '2' is no successor"},
  };
  for (const auto& [text, message] : cases) {
    const auto trace = apps::parse_controller_trace(text, "t.csv");
    ASSERT_FALSE(trace) << text;
    EXPECT_NE(trace.error().message.find(message), std::string::npos) << trace.error().message << "\n" << message;
  }
}

/// What the simulation adds up, done again from the choice alone.
TEST(ControllerTrace, SumsFollowFromTheChoice) {
  for (const auto& trace : bench::synthetic_traces(3)) {
    const apps::TraceResult r = apps::run_controller(trace.frames, true);
    ASSERT_EQ(r.choice.size(), trace.frames.size());
    double chosen = 0.0, oracle = 0.0, cpu = 0.0, gpu = 0.0;
    for (std::size_t i = 0; i < r.choice.size(); ++i) {
      const auto& f = trace.frames[i];
      chosen += r.choice[i] == 'g' ? f.gpu_frame_ms : f.cpu_frame_ms;
      oracle += std::min(f.cpu_frame_ms, f.gpu_frame_ms);
      cpu += f.cpu_frame_ms;
      gpu += f.gpu_frame_ms;
    }
    EXPECT_NEAR(r.chosen_ms, chosen, 1e-9 * chosen);
    EXPECT_NEAR(r.oracle_ms, oracle, 1e-9 * oracle);
    EXPECT_NEAR(r.best_fixed_ms, std::min(cpu, gpu), 1e-9 * cpu);
  }
}

/// The choice up to a frame does not depend on what comes later, nor on the other path's costs.
TEST(ControllerTrace, TheControllerSeesOnlyWhatItMay) {
  for (const auto& trace : bench::synthetic_traces(5)) {
    const std::string choice = apps::run_controller(trace.frames, true).choice;
    auto masked = trace.frames;
    for (std::size_t i = 0; i < masked.size(); ++i)
      (choice[i] == 'g' ? masked[i].cpu_frame_ms : masked[i].gpu_frame_ms) = 1234.5;
    EXPECT_EQ(apps::run_controller(masked, true).choice, choice) << trace.name;
    // Nothing of frame n is known before frame n + 1, and of a GPU's, before n + 3.
    auto changed = trace.frames;
    const std::size_t n = changed.size() / 2;
    for (std::size_t i = n; i < changed.size(); ++i) changed[i].cpu_frame_ms = changed[i].gpu_frame_ms = 77.0;
    std::size_t known = n + 1;
    while (known < n + 1 + apps::kGpuLatency && choice.find('c', n) >= known) ++known;
    EXPECT_EQ(apps::run_controller(changed, true).choice.substr(0, known), choice.substr(0, known)) << trace.name;
  }
}

TEST(ControllerTrace, NextToTheBestPathWhenStationary) {
  constexpr int kSeeds = 20;
  const auto traces = bench::synthetic_traces();
  for (std::size_t t = 0; t < traces.size(); ++t) {
    if (traces[t].kind != bench::TraceClass::kStationary) continue;
    double mean = 0.0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      const auto r = apps::run_controller(bench::synthetic_traces(std::uint64_t(seed))[t].frames, true);
      mean += r.chosen_ms / r.best_fixed_ms / kSeeds;
      EXPECT_LE(double(r.probes), 0.005 * double(r.choice.size())) << traces[t].name << ", seed " << seed;
    }
    // The most expensive trace for noise alone: a spike in a probe costs some frames.
    EXPECT_LE(mean, traces[t].name.find("spikes") == std::string::npos ? 1.01 : 1.02) << traces[t].name;
  }
}

TEST(ControllerTrace, NeverBeyondThreeTimesTheOracle) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    for (const auto& trace : bench::synthetic_traces(seed)) {
      const auto r = apps::run_controller(trace.frames, true);
      EXPECT_LE(r.chosen_ms, 3.0 * r.oracle_ms) << trace.name << ", seed " << seed;
      EXPECT_LE(double(r.probes), 0.005 * double(r.choice.size())) << trace.name << ", seed " << seed;
    }
}

TEST(ControllerTrace, NextToTheOracleOnRecordedTraces) {
  double mean = 0.0;
  for (const char* name : {"plant_713k.csv", "plant_5m.csv"}) {
    const auto trace =
        apps::read_controller_trace(tests::in_checkout(std::string("apps/bench/traces/") + name).string());
    ASSERT_TRUE(trace) << trace.error().message;
    for (const bool rendering : {false, true}) {
      const auto r = apps::run_controller(*trace, rendering);
      mean += r.chosen_ms / r.oracle_ms / 4;
    }
  }
  EXPECT_LE(mean, 1.05);
}

}  // namespace
}  // namespace sightline::tests::controller_trace_test
