// sightline-study with the techniques of GPUs, on little scenes.
#include "sightline/tests/apps/tool_test.h"
#include "sightline/tests/support/no_gl.h"

namespace sightline::tests {
namespace {

using StudyProgram = ToolTest;

TEST_F(StudyProgram, FillsTheTablesOfTheGpu) {
  const Outcome outcome = run("study", {"--gpu", "--tables", "--scale", "0.005", "--frames", "4", "--passes", "1",
                                        "--samples", "2", "--csv", path("csv"), "--json", path("gpu.json")});
  if (outcome.code != 0 && may_skip(outcome.err)) GTEST_SKIP() << outcome.err;
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_FALSE(Json::parse(read_bytes(path("gpu.json")), nullptr, false).is_discarded());
}

}  // namespace
}  // namespace sightline::tests
