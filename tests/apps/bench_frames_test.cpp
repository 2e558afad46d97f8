// sightline-bench frames as a user runs it: its counts and times hang together.
#include "sightline/tests/apps/render_test.h"

namespace sightline::tests::bench_frames_test {
namespace {

class BenchFrames : public RenderTest {};

TEST_F(BenchFrames, VisibleItemsAloneAreFewerAndShowTheSame) {
  const Json json = run_json("bench", {"frames", plant(3000), "--frames", "6", "--size", "96x64"});
  const Json& modes = json["modes"];
  EXPECT_GE(modes["none"]["items"], modes["samples"]["items"]);
  EXPECT_GT(modes["samples"]["items"], modes["both"]["items"]);
  EXPECT_GT(modes["both"]["items"], modes["limit"]["items"]);
  EXPECT_GT(modes["limit"]["items"], 10.0);
  EXPECT_LT(json["other_ids"], 6 * 96 * 64 / 100) << "ties may differ";
  EXPECT_EQ(modes["limit"]["mean_ratio"], 1.0);
  for (const char* mode : {"samples", "both", "limit", "none"}) {
    EXPECT_GT(modes[mode]["ms"]["mean"], 0.0) << mode;
    EXPECT_LE(modes[mode]["ms"]["median"], modes[mode]["ms"]["max"]) << mode;
    EXPECT_GE(modes[mode]["processor_ms"], 0.0) << mode;
  }
}

TEST_F(BenchFrames, RefusesWhatMakesNoSense) {
  expect_usage_error("bench", {"frames"}, "--items");
  expect_usage_error("bench", {"frames", plant(1000), "--frames", "1"}, "--frames");
  expect_usage_error("bench", {"frames", plant(1000), "--size", "0x5"}, "--size");
  expect_failure("bench", {"frames", path("none.rvm")}, "none.rvm", true);
}

}  // namespace
}  // namespace sightline::tests::bench_frames_test
