// sightline-study with the techniques of GPUs, on little scenes.
#include "sightline/tests/apps/tool_test.h"
#include "sightline/tests/support/no_gl.h"

namespace sightline::tests::program_test {
namespace {

using StudyProgram = ToolTest;

TEST_F(StudyProgram, FillsTheTablesOfTheGpu) {
  const Outcome outcome = run("study", {"--gpu", "--tables", "--scale", "0.005", "--frames", "4", "--passes", "1",
                                        "--samples", "2", "--csv", path("csv"), "--json", path("gpu.json")});
  if (outcome.code != 0 && may_skip(outcome.err)) GTEST_SKIP() << outcome.err;
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_TRUE(json::parse(read_bytes(path("gpu.json"))));
}

TEST_F(StudyProgram, TracesRaysInGlsl) {
  const Outcome outcome =
      run("study", {"rays", "--gpu", "--tables", "--size", "64x40", "--passes", "1", "--scan", "2000", "--scattered",
                    "2000", "--csv", path("csv"), "--json", path("rays.json")});
  if (outcome.code != 0 && may_skip(outcome.err)) GTEST_SKIP() << outcome.err;
  ASSERT_EQ(outcome.code, 0) << outcome;
  const Json json = json::parse(read_bytes(path("rays.json"))).value();
  ASSERT_EQ(json.size(), 2u);
  for (const Json& model : json)
    for (const Json& run : model["traversals"]) EXPECT_EQ(run["glsl"]["disagreements"], 0) << run;
  EXPECT_NE(read_bytes(path("csv/rays_glsl.csv")).find("scan,2028,kd ropes++,"), std::string::npos);
}

TEST_F(StudyProgram, BuildsGridsOnTheGpu) {
  const Outcome outcome = run("study", {"grids", "--tables", "--size", "32x24", "--passes", "1", "--only", "PRI_I",
                                        "DIST_III", "--csv", path("csv")});
  if (outcome.code != 0 && may_skip(outcome.err)) GTEST_SKIP() << outcome.err;
  ASSERT_EQ(outcome.code, 0) << outcome;
  EXPECT_NE(read_bytes(path("csv/grids.csv")).find("5.6,PRI_I,194,2,2,"), std::string::npos);
}

}  // namespace
}  // namespace sightline::tests::program_test
