// What every subcommand of sightline-bench promises on its command line, and quick runs of those without tests of their
// own.
#include "sightline/tests/apps/tool_test.h"

namespace sightline::tests::bench_test {
namespace {

class Bench : public ToolTest {
 protected:
  /// The names that --help lists.
  std::vector<std::string> subcommands() const {
    const Outcome outcome = run("bench", {"--help"});
    EXPECT_EQ(outcome.code, 0) << outcome;
    std::istringstream help(outcome.out.substr(outcome.out.find("Subcommands:")));
    std::vector<std::string> names;
    std::string line;
    std::getline(help, line);
    while (std::getline(help, line) && !line.empty()) names.push_back(line.substr(2, line.find(' ', 2) - 2));
    return names;
  }

  /// One view from outside a made-up plant.
  std::string view_file() const {
    const std::array<double, 16> clip_from_world = {0.01, 0, 0, 0, 0, 0.01, 0, 0, 0, 0, -0.01, 0, -1, -1, 0, 1};
    return write("views.f64", std::string(reinterpret_cast<const char*>(clip_from_world.data()), 128));
  }
};

TEST_F(Bench, ListsItsSubcommands) {
  const std::vector<std::string> names = subcommands();
  for (const char* name : {"cull", "edit", "import", "queries", "start"})
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
  const auto with_gl = std::count(names.begin(), names.end(), "hybrid");
  for (const char* name : {"error-time", "frames"})
    EXPECT_EQ(std::count(names.begin(), names.end(), name), with_gl) << name;
}

TEST_F(Bench, EverySubcommandHasHelpWithExamples) {
  for (const std::string& name : subcommands()) {
    const Outcome outcome = run("bench", {name, "--help"});
    EXPECT_EQ(outcome.code, 0) << outcome;
    EXPECT_EQ(outcome.err, "");
    const std::size_t examples = outcome.out.find("Examples:");
    ASSERT_NE(examples, std::string::npos) << outcome;
    EXPECT_NE(outcome.out.find("sightline-bench " + name, examples), std::string::npos) << outcome;
    EXPECT_NE(outcome.out.find("--json"), std::string::npos) << outcome;
    expect_usage_error("bench", {name, "--json"}, "--json");
  }
}

TEST_F(Bench, RefusesWhatItDoesNotKnow) {
  expect_usage_error("bench", {}, "subcommand");
  expect_usage_error("bench", {"no-such-subcommand"}, "subcommand");
  expect_usage_error("bench", {"edit", "--no-such-flag"}, "--no-such-flag");
  EXPECT_EQ(run("bench", {"--version"}).code, 0);
}

TEST_F(Bench, MeasuresEdits) {
  const Json json = run_json("bench", {"edit", "--items", "2000", "--commits", "1", "--views", view_file()});
  EXPECT_EQ(json["edits"].size(), 6u);
  EXPECT_GT(json["rebuild"]["rebuild_ms"], 0.0);
  ASSERT_EQ(json["boxes"].size(), 2u);
  EXPECT_GT(json["boxes"][0]["batch_us"], 0.0);
  const Json boxes =
      run_json("bench", {"edit", "--subject", "boxes", "--items", "2000", "--commits", "1", "--views", view_file()});
  EXPECT_FALSE(boxes.contains("edits"));
  EXPECT_EQ(boxes["boxes"].size(), 2u);
}

TEST_F(Bench, NamesASubcommandThatThereIsNot) {
  expect_usage_error("bench", {"culling"}, "no subcommand \"culling\": expected one of cull, ");
}

TEST_F(Bench, MeasuresImports) {
  const Json json = run_json("bench", {"import", plant(1000), "--passes", "1"});
  ASSERT_EQ(json.size(), 1u);
  EXPECT_EQ(json[0]["items"], 1000);
  expect_failure("bench", {"import", path("none.rvm")}, "none.rvm");
}

TEST_F(Bench, MeasuresQueries) {
  const Json json = run_json("bench", {"queries", "--generate", "2000"});
  ASSERT_EQ(json["queries"].size(), 9u);
  for (const Json& row : json["queries"]) {
    EXPECT_GT(row["found"], 0.0) << row;
    EXPECT_GT(row["hierarchy_us"], 0.0) << row;
    EXPECT_GT(row["linear_us"], 0.0) << row;
  }
  EXPECT_EQ(run("bench", {"queries", "--generate", "2000", "--json", unwritable("out.json")}).code, 1);
}

}  // namespace
}  // namespace sightline::tests::bench_test
