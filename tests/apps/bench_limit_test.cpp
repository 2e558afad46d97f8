// sightline-bench limit as a user runs it: figures hang together.
#include "sightline/tests/apps/render_test.h"

namespace sightline::tests::bench_limit_test {
namespace {

class BenchLimit : public RenderTest {};

TEST_F(BenchLimit, OwnersAloneAreFewerAndShowTheSame) {
  const Json json = run_json("bench", {"limit", plant(3000), "--frames", "6", "--size", "96x64"});
  const Json& ways = json["ways"];
  EXPECT_GT(ways["samples"]["items"], ways["both"]["items"]);
  EXPECT_GT(ways["both"]["items"], ways["limit"]["items"]);
  EXPECT_GT(ways["limit"]["items"], 10.0);
  EXPECT_LT(ways["other_ids"], 6 * 96 * 64 / 100) << "ties may differ";
  EXPECT_EQ(ways["limit"]["mean_ratio"], 1.0);
  for (const char* way : {"samples", "both", "limit"}) {
    EXPECT_GT(ways[way]["ms"]["mean"], 0.0) << way;
    EXPECT_LE(ways[way]["ms"]["median"], ways[way]["ms"]["max"]) << way;
    EXPECT_GE(ways[way]["processor_ms"], 0.0) << way;
  }
}

TEST_F(BenchLimit, RefusesWhatMakesNoSense) {
  expect_usage_error("bench", {"limit", plant(1000), "--frames", "1"}, "--frames");
  expect_usage_error("bench", {"limit", plant(1000), "--size", "0x5"}, "--size");
  expect_failure("bench", {"limit", path("none.rvm")}, "none.rvm", true);
}

}  // namespace
}  // namespace sightline::tests::bench_limit_test
