// sightline-study budget as a user runs it: figures hang together.
#include "sightline/study/tests/study_program_gl.h"

namespace sightline::tests::budget_test {
namespace {

class Budget : public StudyGlTest {
 protected:
  Json measure(const std::string& model, const std::string& budget, const std::string& mode = "drop") const {
    return run_json("study", {"budget", model, "--frames", "12", "--compared", "3", "--rests", "2", "--size", "96x64",
                              "--budget", budget, "--mode", mode});
  }
};

TEST_F(Budget, TimeEnoughGivesTheFullImage) {
  const Json json = measure(plant(3000), "100000");
  EXPECT_EQ(json["moving"]["within"], 1.0);
  EXPECT_EQ(json["moving"]["complete"], 1.0);
  for (const char* mode : {"budget", "contribution"}) {
    EXPECT_LT(json["compared"][mode]["flip"]["mean"], 1e-3) << mode << ": ties may differ";
    EXPECT_LT(json["compared"][mode]["wrong_ids"], 1e-2) << mode;
    EXPECT_EQ(json["compared"][mode]["flips"].size(), 3u);
  }
  EXPECT_EQ(json["compared"]["contribution"]["thresholds"], Json::array({0.0, 0.0, 0.0}));
  EXPECT_EQ(json["rest"]["frames"]["max"], 1.0);
  EXPECT_EQ(json["together"]["frames"], 4.0);
}

TEST_F(Budget, NoTimeLosesMostAndIsMadeUpForAtRest) {
  const Json json = measure(plant(12000), "0.01");
  EXPECT_LT(json["moving"]["complete"], 0.5);
  EXPECT_GT(json["moving"]["items_drawn"], 0.0);
  EXPECT_GT(json["compared"]["budget"]["flip"]["mean"], 1e-3);
  EXPECT_GT(json["compared"]["budget"]["wrong_ids"], 1e-3);
  EXPECT_LE(json["compared"]["budget"]["flip"]["mean"], json["compared"]["budget"]["flip"]["p99"]);
  EXPECT_GT(json["rest"]["frames"]["mean"], 2.0);
  EXPECT_GT(json["together"]["frames"], 8.0);
  for (const Json& threshold : json["compared"]["contribution"]["thresholds"]) EXPECT_EQ(threshold, 1024.0);
  const Json squares = measure(plant(12000), "0.01", "points");
  EXPECT_LT(squares["compared"]["budget"]["flip"]["mean"], json["compared"]["budget"]["flip"]["mean"]);
}

TEST_F(Budget, RefusesWhatMakesNoSense) {
  expect_usage_error("study", {"budget", plant(1000), "--budget", "0"}, "--budget");
  expect_usage_error("study", {"budget", plant(1000), "--frames", "1"}, "--frames");
  expect_usage_error("study", {"budget", plant(1000), "--mode", "magic"}, "--mode");
  expect_failure("study", {"budget", path("none.rvm")}, "none.rvm", true);
}

}  // namespace
}  // namespace sightline::tests::budget_test
