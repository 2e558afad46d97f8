// sightline-bench contribution and lod as a user runs them: counts and errors hang together.
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
  for (const Json& rule : json["rules"]) rules[rule["name"].get<std::string>()].push_back(rule);
  ASSERT_EQ(rules["full"].size(), 1u);
  ASSERT_EQ(rules["primitives"].size(), 1u);
  const auto mean = [](const Json& rule, const char* measure) { return rule[measure]["mean"].get<double>(); };
  EXPECT_LT(mean(rules["primitives"][0], "triangles"), mean(rules["full"][0], "triangles"));
  if (rules["levels"].empty()) GTEST_SKIP() << "no meshoptimizer";
  ASSERT_EQ(rules["chain"].size(), rules["levels"].size());
  double triangles = mean(rules["full"][0], "triangles");
  for (const Json& rule : rules["levels"]) {
    EXPECT_LE(mean(rule, "triangles"), triangles);
    triangles = mean(rule, "triangles");
    EXPECT_LE(rule["bound"]["max"], rule["threshold"]);
    EXPECT_TRUE(!rule.contains("tightness") || rule["tightness"]["median"] >= 1.0);
  }
}

TEST_F(BenchLosses, LessIsDrawnWithARisingThreshold) {
  const Json json = measure("contribution", plant(1000), "drop,osg");
  ASSERT_EQ(json["rules"].size(), 11u);
  for (const int first : {1, 6})
    for (int i = first + 1; i < first + 5; ++i)
      EXPECT_LE(json["rules"][i]["items"]["mean"], json["rules"][i - 1]["items"]["mean"]);
  expect_usage_error("bench", {"lod", plant(1000), "--rules", "magic"}, "--rules");
}

}  // namespace
}  // namespace sightline::tests::bench_losses_test
