// sightline-study with the techniques of GPUs, on little scenes.
#include "sightline/tests/apps/tool_test.h"
#include "sightline/tests/support/no_gl.h"

namespace sightline::tests::program_gl_test {
namespace {

class StudyProgram : public ToolTest {
 protected:
  /// The JSON of a run; null where there is no GL, which skips the test or fails it.
  Json run_with_gl(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--json", path("out.json")});
    const Outcome outcome = run("study", arguments);
    if (outcome.code != 0 && may_skip(outcome.err)) return {};
    EXPECT_EQ(outcome.code, 0) << outcome;
    return json::parse(read_bytes(path("out.json"))).value_or(Json());
  }
};

TEST_F(StudyProgram, FillsTheTablesOfTheGpu) {
  const Json json = run_with_gl(
      {"cull-gpu", "--scale", "0.005", "--frames", "4", "--passes", "1", "--samples", "2", "--plots", path("plots")});
  if (json.is_null()) GTEST_SKIP() << "no GL";
  EXPECT_EQ(json.size(), 9u);  // culling of five models, drawing of the platforms' cylinders
  for (const Json& figure : json)
    for (const Json& run : figure["runs"]) EXPECT_EQ(run["false_negatives"], 0.0) << run;
  EXPECT_GT(read_bytes(path("plots/figure_5_14_P-50.svg")).size(), 500u);
}

TEST_F(StudyProgram, TracesRaysInGlsl) {
  const Json json =
      run_with_gl({"rays", "--gpu", "--size", "64x40", "--passes", "1", "--scan", "2000", "--scattered", "2000"});
  if (json.is_null()) GTEST_SKIP() << "no GL";
  ASSERT_EQ(json.size(), 2u);
  for (const Json& model : json)
    for (const Json& run : model["traversals"]) EXPECT_EQ(run["glsl"]["disagreements"], 0) << run;
}

TEST_F(StudyProgram, TracesGridsOfAllSizes) {
  const Json json = run_with_gl({"grids", "--size", "32x24", "--passes", "1", "--only", "PRI_I", "DIST_III"});
  if (json.is_null()) GTEST_SKIP() << "no GL";
  ASSERT_EQ(json.size(), 2u);
  EXPECT_EQ(json[0]["triangles"], 194);
  for (const Json& scene : json)
    for (const Json& image : scene["images"]) EXPECT_EQ(image["disagreements"], 0) << image;
}

}  // namespace
}  // namespace sightline::tests::program_gl_test
