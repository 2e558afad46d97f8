// sightline-bench contribution and lod as a user runs them: figures hang together.
#include "sightline/tests/apps/render_test.h"

namespace sightline::tests::bench_losses_test {
namespace {

class BenchLosses : public RenderTest {
 protected:
  Json measure(const char* command, const std::string& model, const std::string& rules) const {
    return run_json("bench", {command, model, "--frames", "1", "--passes", "1", "--size", "96x64", "--rules", rules});
  }
};

TEST_F(BenchLosses, LevelsLieWithinTheirBound) {
  const std::string meshes = path("meshes.obj");
  ASSERT_EQ(run("convert", {plant(1000), meshes}).code, 0);
  const Json json = measure("lod", meshes, "levels,chain,primitives");
  std::map<std::string, std::vector<Json>> rules;
  for (const Json& rule : json["rules"]) rules[rule["rule"].get<std::string>()].push_back(rule);
  ASSERT_EQ(rules["full"].size(), 1u);
  ASSERT_EQ(rules["primitives"].size(), 1u);
  EXPECT_LT(rules["primitives"][0]["triangles"], rules["full"][0]["triangles"]);
  if (rules["levels"].empty()) GTEST_SKIP() << "no meshoptimizer";
  ASSERT_EQ(rules["chain"].size(), rules["levels"].size());
  double triangles = rules["full"][0]["triangles"].get<double>();
  for (const Json& rule : rules["levels"]) {
    EXPECT_LE(rule["triangles"], triangles);
    triangles = rule["triangles"].get<double>();
    const Json& bound = rule["surface_px"]["bound"][0];
    EXPECT_LE(bound, rule["threshold"]);
    const double tightness = rule["surface_px"]["tightness"]["median"].get<double>();
    EXPECT_TRUE(tightness == 0.0 || tightness >= 1.0) << tightness;
  }
}

TEST_F(BenchLosses, LessIsDrawnWithARisingThreshold) {
  const Json json = measure("contribution", plant(1000), "drop,sphere");
  ASSERT_EQ(json["rules"].size(), 11u);
  for (const int first : {1, 6})
    for (int i = first + 1; i < first + 5; ++i) EXPECT_LE(json["rules"][i]["items"], json["rules"][i - 1]["items"]);
  expect_usage_error("bench", {"lod", plant(1000), "--rules", "magic"}, "--rules");
}

}  // namespace
}  // namespace sightline::tests::bench_losses_test
