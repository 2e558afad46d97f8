// sightline-study as a user runs it, on little scenes: all that needs no GL.
#include "sightline/tests/apps/tool_test.h"

namespace sightline::tests::program_test {
namespace {

using StudyProgram = ToolTest;

TEST_F(StudyProgram, HasHelpWithExamplesOfEachSubcommand) {
  for (const std::string name : {"cull", "controller", "rays"}) {
    const Outcome outcome = run("study", {name, "--help"});
    EXPECT_EQ(outcome.code, 0) << outcome;
    EXPECT_EQ(outcome.err, "");
    const std::size_t examples = outcome.out.find("Examples:");
    ASSERT_NE(examples, std::string::npos) << outcome;
    EXPECT_NE(outcome.out.find("sightline-study " + name, examples), std::string::npos) << outcome;
    expect_usage_error("study", {name, "--json"}, "--json");
  }
}

TEST_F(StudyProgram, FillsTheTablesOfCulling) {
  const Outcome outcome = run("study", {"cull", "--scale", "0.002", "--frames", "4", "--passes", "1", "--samples", "2",
                                        "--plots", path("plots"), "--json", path("cull.json")});
  ASSERT_EQ(outcome.code, 0) << outcome;
  for (const char* table : {"Table 4.1", "Table 4.2", "Tables 4.3, 4.4", "Tables 4.5, 4.6", "Table 4.8", "Table 4.9"})
    EXPECT_NE(outcome.out.find(table), std::string::npos) << table;
  EXPECT_EQ(json::parse(read_bytes(path("cull.json"))).value().size(), 5u);
  for (const char* figure : {"4_1_P-38", "4_2_aircraft", "4_13_P-50", "4_16_aircraft"})
    EXPECT_GT(read_bytes(path(std::string("plots/figure_") + figure + ".svg")).size(), 500u) << figure;
  expect_failure("study", {"cull", "--only", "P-39"}, "no such model");
}

TEST_F(StudyProgram, ComparesTraversals) {
  const Json json = run_json("study", {"rays", "--size", "64x40", "--passes", "1", "--scan", "12,2000", "--scattered",
                                       "2000", "--plot", path("growth.svg")});
  ASSERT_EQ(json.size(), 3u);
  for (const Json& model : json)
    for (const Json& traversal : model["traversals"]) EXPECT_EQ(traversal["disagreements"], 0) << traversal;
  EXPECT_GT(read_bytes(path("growth.svg")).size(), 500u);
}

TEST_F(StudyProgram, MeasuresTheController) {
  const Json json = run_json("study", {"controller", "--seeds", "1", "--plot", path("regret.svg")});
  ASSERT_GT(json["traces"].size(), 5u);
  for (const Json& trace : json["traces"]) EXPECT_GE(trace["controller"]["chosen_to_oracle"], 1.0) << trace;
  EXPECT_GT(read_bytes(path("regret.svg")).size(), 500u);
}

}  // namespace
}  // namespace sightline::tests::program_test
