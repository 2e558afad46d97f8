// sightline-bench frames, motion, passes and prepare as a user runs them: their counts and times hang together.
#include "sightline/tests/apps/render_test.h"
#include "sightline/tests/support/effort.h"
#include "sightline/tests/support/places.h"

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

TEST_F(BenchFrames, PassesColourWhatAllOfThemDo) {
  for (const char* samples : {"1", "4"}) {
    const Json json =
        run_json("bench", {"passes", plant(3000), "--frames", "3", "--size", "96x64", "--samples", samples});
    const Json& passes = json["passes"];
    double items = 0.0, coloured = 0.0;
    for (const auto& [name, pass] : passes.items()) {
      EXPECT_GT(pass["ms"]["median"], 0.0) << name;
      if (name.rfind("all kinds", 0) == 0 || !pass.contains("coloured")) continue;
      items += pass["items"].get<double>();
      coloured += pass["coloured"].get<double>();
      EXPECT_TRUE(!pass.contains("fragments") || pass["fragments"].get<double>() * 4.01 >= 1.0) << pass;
    }
    EXPECT_NEAR(passes["all kinds"]["items"].get<double>(), items, 1e-6 * items);
    EXPECT_GT(passes["all kinds"]["coloured"].get<double>(), 0.03);
    EXPECT_LE(passes["all kinds"]["coloured"].get<double>(), coloured) << "some hide others";
    EXPECT_FALSE(passes["all kinds again, over their depth"].contains("coloured")) << "the nearest ones are there";
    EXPECT_EQ(passes.contains("resolve samples"), samples[0] == '4');
  }
}

TEST_F(BenchFrames, AnyNumberOfThreadsPreparesTheSame) {
  const std::string views = std::to_string(repeated(1000, 100));
  const Json json = run_json("bench", {"prepare", "--items", "50000", "--frames", views, "--verify"});
  EXPECT_EQ(json["verified"], true);
  const std::string meshes = in_checkout("tests/data/small_plant.rvm").string();
  EXPECT_EQ(run_json("bench", {"prepare", meshes, "--frames", views, "--verify"})["verified"], true);
}

/// A budget that no frame keeps still shows most of so small an image, and the way without one all of it.
TEST_F(BenchFrames, MovingImagesAreComparedWithCompleteOnes) {
  const Json json = run_json("bench", {"motion", plant(3000), "--frames", "8", "--every", "2", "--size", "192x128",
                                       "--budget", "0.001", "--ways", "traced,complete", "--images", path("frames"),
                                       "--strip", path("strip.png"), "--plot", path("motion.svg")});
  ASSERT_EQ(json["rows"].size(), 6u) << json;
  for (const Json& row : json["rows"]) {
    const bool complete = row["way"] == "complete";
    EXPECT_GT(row["ms"]["median"], 0.0);
    EXPECT_GT(row["covered"], complete ? 0.9999 : 0.4) << row;
    EXPECT_GT(row["right_item"], complete ? 0.9999 : 0.1) << row;
    if (complete) {
      EXPECT_EQ(row["flip"], 0.0) << row;
      EXPECT_EQ(row["pending"], 0.0) << row;
      EXPECT_EQ(row["coarseness"], 1.0) << row;
    } else {
      EXPECT_GT(row["flip"], 0.0) << row;
      EXPECT_GT(row["coarseness"], 1.0) << row;
    }
  }
  EXPECT_NE(read_bytes(path("motion.svg")).find("complete"), std::string::npos);
  EXPECT_EQ(read_bytes(path("frames/walk-0-complete.png")), read_bytes(path("frames/walk-0-whole.png")));
  expect_usage_error("bench", {"motion"}, "--items");
  expect_usage_error("bench", {"motion", plant(1000), "--ways", "fast"}, "--ways");
}

}  // namespace
}  // namespace sightline::tests::bench_frames_test
