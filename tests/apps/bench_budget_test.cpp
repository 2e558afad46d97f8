// sightline-bench budget as a user runs it: figures hang together.
#include "sightline/tests/apps/render_test.h"

namespace sightline::tests::bench_budget_test {
namespace {

class BenchBudget : public RenderTest {
 protected:
  Json measure(const std::string& model, const std::string& budget, const std::string& way = "drop") const {
    return run_json("bench", {"budget", model, "--frames", "12", "--compared", "3", "--rests", "2", "--size", "96x64",
                              "--budget", budget, "--way", way});
  }
};

TEST_F(BenchBudget, TimeEnoughGivesTheFullPicture) {
  const Json json = measure(plant(3000), "100000");
  EXPECT_EQ(json["moving"]["within"], 1.0);
  EXPECT_EQ(json["moving"]["complete"], 1.0);
  for (const char* way : {"budget", "contribution"}) {
    EXPECT_LT(json["compared"][way]["flip"]["mean"], 1e-3) << way << ": ties may differ";
    EXPECT_LT(json["compared"][way]["wrong_ids"], 1e-2) << way;
    EXPECT_EQ(json["compared"][way]["flips"].size(), 3u);
  }
  EXPECT_EQ(json["compared"]["contribution"]["thresholds"], Json::array({0.0, 0.0, 0.0}));
  EXPECT_EQ(json["rest"]["frames"]["max"], 1.0);
  EXPECT_EQ(json["together"]["frames"], 4.0);
}

TEST_F(BenchBudget, NoTimeLosesMostAndIsMadeUpForAtRest) {
  const Json json = measure(plant(12000), "0.01");
  EXPECT_LT(json["moving"]["complete"], 0.5);
  EXPECT_GT(json["moving"]["shown"], 0.0);
  EXPECT_GT(json["compared"]["budget"]["flip"]["mean"], 1e-3);
  EXPECT_GT(json["compared"]["budget"]["wrong_ids"], 1e-3);
  EXPECT_LE(json["compared"]["budget"]["flip"]["mean"], json["compared"]["budget"]["flip"]["p99"]);
  EXPECT_GT(json["rest"]["frames"]["mean"], 2.0);
  EXPECT_GT(json["together"]["frames"], 8.0);
  for (const Json& threshold : json["compared"]["contribution"]["thresholds"]) EXPECT_EQ(threshold, 1024.0);
  const Json squares = measure(plant(12000), "0.01", "points");
  EXPECT_LT(squares["compared"]["budget"]["flip"]["mean"], json["compared"]["budget"]["flip"]["mean"]);
}

TEST_F(BenchBudget, RefusesWhatMakesNoSense) {
  expect_usage_error("bench", {"budget", plant(1000), "--budget", "0"}, "--budget");
  expect_usage_error("bench", {"budget", plant(1000), "--frames", "1"}, "--frames");
  expect_usage_error("bench", {"budget", plant(1000), "--way", "magic"}, "--way");
  expect_failure("bench", {"budget", path("none.rvm")}, "none.rvm", true);
}

}  // namespace
}  // namespace sightline::tests::bench_budget_test
