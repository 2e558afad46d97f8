// sightline-study with the techniques of GPUs, on little scenes.
#include "sightline/tests/apps/render_test.h"

namespace sightline::tests {
namespace {

using StudyProgram = RenderTest;

TEST_F(StudyProgram, FillsTheTablesOfTheGpu) {
  const Outcome outcome = run("study", {"--gpu", "--tables", "--scale", "0.005", "--frames", "4", "--passes", "1",
                                        "--samples", "2", "--csv", path("csv"), "--json", path("gpu.json")});
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_FALSE(Json::parse(read_bytes(path("gpu.json")), nullptr, false).is_discarded());
}

}  // namespace
}  // namespace sightline::tests
