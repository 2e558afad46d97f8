// What every tool promises on its command line: help, exit codes, and one clear line about bad input.
#include "sightline/tests/apps/tool_test.h"

namespace sightline::tests::command_line_test {
namespace {

class EveryTool : public ToolTest, public ::testing::WithParamInterface<std::string> {
 protected:
  /// Arguments without which the tool refuses to start, naming files that need not exist.
  Args required() const {
    if (GetParam() == "compare") return {path("old.rvm"), path("new.rvm")};
    if (GetParam() == "convert") return {path("model.rvm"), path("out.rvm")};
    if (GetParam() == "report") return {path("model.rvm"), "--out", path("report.html")};
    if (GetParam() == "regress") return {path("suite.json")};
    return {path("model.rvm")};
  }
  Args required_and(const Args& more) const {
    Args args = required();
    args.insert(args.end(), more.begin(), more.end());
    return args;
  }
};

TEST_P(EveryTool, HelpNamesItsOptionsAndShowsExamples) {
  const Outcome outcome = run(GetParam(), {"--help"});
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_EQ(outcome.err, "");
  const std::size_t examples = outcome.out.find("Examples:");
  ASSERT_NE(examples, std::string::npos) << outcome;
  EXPECT_NE(outcome.out.find("sightline-" + GetParam(), examples), std::string::npos) << outcome;
  for (const char* option : {"--help", "--help-all", "--version", "--json"})
    EXPECT_NE(outcome.out.find(option), std::string::npos) << option << "\n" << outcome;
  EXPECT_LE(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 45) << outcome;
}

TEST_P(EveryTool, TellsItsVersion) {
  const Outcome outcome = run(GetParam(), {"--version"});
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_EQ(outcome.out.rfind("sightline", 0), 0u) << outcome;
  EXPECT_NE(outcome.out.find_first_of("0123456789"), std::string::npos) << outcome;
}

TEST_P(EveryTool, RefusesAnUnknownFlag) {
  expect_usage_error(GetParam(), required_and({"--no-such-flag"}), "--no-such-flag");
}

TEST_P(EveryTool, RefusesMissingArguments) {
  if (GetParam() != "view") expect_usage_error(GetParam(), {}, "required");  // a window may begin without a model
  expect_usage_error(GetParam(), required_and({"--json"}), "--json");
}

INSTANTIATE_TEST_SUITE_P(All, EveryTool, ::testing::ValuesIn(built_tools()), [](const auto& tool) {
  std::string name = tool.param;
  std::erase(name, '-');
  return name;
});

/// The tools that read models, but for sightline-view, which opens its window first (View.RefusesWhatIsNoModel). None
/// of these runs comes so far as to draw.
class ModelTool : public ToolTest, public ::testing::WithParamInterface<std::string> {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    if (!is_built(GetParam())) GTEST_SKIP() << "sightline-" << GetParam() << " is not part of this build";
  }

  /// Arguments after those that the tool cannot do without.
  Args with(const Args& args) const {
    Args all;
    if (GetParam() == "report") all = {"--out", path("report.html")};
    if (GetParam() == "render" || GetParam() == "trace") all = {"--out", path("image.png")};
    all.insert(all.end(), args.begin(), args.end());
    return all;
  }
};

TEST_P(ModelTool, RefusesWhatIsNoModel) {
  const std::string good = plant(1000);
  for (const std::string& file : bad_models()) {
    const std::string name = fs::path(file).filename().string();
    expect_failure(GetParam(), with({file}), name);
    expect_failure(GetParam(), with({good, file}), name);
  }
}

TEST_P(ModelTool, RefusesBadTranslations) {
  for (const char* bad : {"1,2", "1,2,3,4", "1;2;3", "x", "", "nan,0,0", "0,inf,0", "1,2,3m"})
    expect_usage_error(GetParam(), with({"model.rvm", "--translate", bad}), "--translate");
  expect_usage_error(GetParam(), with({"model.rvm", "--translate"}), "--translate");
}

TEST_P(ModelTool, RefusesTranslationsBeyondAllRange) {
  expect_failure(GetParam(), with({plant(1000), "--translate", "1e300,0,0"}), "beyond");
}

INSTANTIATE_TEST_SUITE_P(All, ModelTool, ::testing::Values("info", "replay", "render", "report", "trace"));

using CommandLine = ToolTest;

TEST_F(CommandLine, InfoRefusesAnUnwritableOutput) {
  const std::string model = plant(1000), bad = unwritable("a.json");
  expect_failure("info", {model, "--json", bad}, bad);
}

TEST_F(CommandLine, GenerateRefusesAnUnwritableOutput) {
  const std::string bad = unwritable("a.rvm");
  expect_failure("generate", {bad, "--items", "1000"}, bad);
  expect_failure("generate", {path("good.rvm"), "--items", "1000", "--json", bad}, bad);
  fs::create_directories(path("folder"));
  expect_failure("generate", {path("folder"), "--items", "1000"}, path("folder"));
}

TEST_F(CommandLine, GenerateRefusesNumbersOutOfRange) {
  const std::string out = path("out.rvm");
  for (const char* bad : {"999", "10000001", "0", "-1", "1e4", "many", "18446744073709552616", "4294968296", ""})
    expect_usage_error("generate", {out, "--items", bad}, "--items");
  for (const char* bad : {"-1", "x", "1.5", "18446744073709551616"})
    expect_usage_error("generate", {out, "--seed", bad}, "--seed");
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(CommandLine, ReplayRefusesUnwritableOutputs) {
  const std::string model = plant(1000), bad = unwritable("a");
  for (const char* option : {"--json", "--csv", "--plot", "--save-path"})
    expect_failure("replay", {model, "--no-render", "--frames", "2", option, bad}, bad);
  expect_failure("replay", {model, "--frames", "2", "--images", bad}, bad);
}

TEST_F(CommandLine, ReplayRefusesBadOptions) {
  for (const char* bad : {"0x5", "5", "5x", "x5", "5x5x5", "-4x4", "16385x4", "4x99999999999", "4.5x4", ""})
    expect_usage_error("replay", {"model.rvm", "--size", bad}, "--size");
  for (const char* bad : {"0", "-3", "1000001", "2.5", "ten"})
    expect_usage_error("replay", {"model.rvm", "--frames", bad}, "--frames");
  expect_usage_error("replay", {"model.rvm", "--culler", "magic"}, "--culler");
  expect_usage_error("replay", {"model.rvm", "--every", "3"}, "--every");
  expect_usage_error("replay", {"model.rvm", "--images", path("images"), "--every", "0"}, "--every");
  expect_usage_error("replay", {"model.rvm", "--no-render", "--images", path("images")}, "--images");
  EXPECT_FALSE(fs::exists(path("images")));
}

TEST_F(CommandLine, ReplayRefusesBadPaths) {
  const std::string model = plant(1000);
  const std::string key = R"({"t":0,"eye":[0,0,0],"target":[1,0,0],"fovy_deg":60})";
  const std::string later = R"({"t":1,"eye":[0,1,0],"target":[1,0,0]})";
  const std::vector<std::string> bad = {
      "",
      "no JSON",
      "{",
      "null",
      "[]",
      "{}",
      R"({"keys":[],"near":0.1})",
      R"({"keys":{},"near":0.1})",
      R"({"keys":[1],"near":0.1})",
      R"({"keys":[)" + key + "]}",
      R"({"keys":[)" + key + R"(],"near":0})",
      R"({"keys":[)" + key + R"(],"near":"close"})",
      R"({"keys":[)" + key + R"(],"near":1,"far":0.5})",
      R"({"keys":[)" + later + "," + key + R"(],"near":0.1})",
      R"({"keys":[{"t":"now","eye":[0,0,0],"target":[1,0,0],"fovy_deg":60}],"near":0.1})",
      R"({"keys":[{"t":0,"eye":[0,0],"target":[1,0,0],"fovy_deg":60}],"near":0.1})",
      R"({"keys":[{"t":0,"eye":[0,0,0],"target":[0,0,0],"fovy_deg":60}],"near":0.1})",
      R"({"keys":[{"t":0,"eye":[0,0,1e999],"target":[1,0,0],"fovy_deg":60}],"near":0.1})",
      R"({"keys":[{"t":0,"eye":[0,0,0],"target":[1,0,0],"fovy_deg":180}],"near":0.1})",
      R"({"keys":[{"t":0,"eye":[0,0,0],"target":[1,0,0]}],"near":0.1})",
      R"({"keys":[)" + key + "," + key.substr(0, 5) + "1" + key.substr(6) + "," + later +
          R"(,{"t":0.5,"eye":[0,0,0],"target":[1,0,0]}],"near":0.1})",
      std::string(1 << 20, '['),
  };
  for (const std::string& text : bad) {
    SCOPED_TRACE(text.substr(0, 200));
    const std::string file = write("path.json", text);
    expect_failure("replay", {model, "--no-render", "--frames", "2", "--path", file}, file);
  }
  for (const std::string& file : {path("missing.json"), path("")})
    expect_failure("replay", {model, "--no-render", "--frames", "2", "--path", file}, file);
  const std::string good = write("path.json", R"({"keys":[)" + key + "," + later + R"(],"near":0.1})");
  EXPECT_EQ(run("replay", {model, "--no-render", "--frames", "2", "--path", good}).code, 0);
}

TEST_F(CommandLine, RenderRefusesBadOptions) {
  if (!is_built("render")) GTEST_SKIP() << "sightline-render is not part of this build";
  for (const char* bad : {"0x5", "5", "5x", "x5", "5x5x5", "-4x4", "16385x4", "4x99999999999", "4.5x4", ""})
    expect_usage_error("render", {"model.rvm", "--size", bad}, "--size");
  for (const char* option : {"--max", "--mean"}) {
    expect_usage_error("render", {"model.rvm", option, "3"}, option);  // without --compare
    for (const char* bad : {"-1", "256", "nan", "x"})
      expect_usage_error("render", {"model.rvm", "--compare", "a.png", option, bad}, option);
  }
  expect_usage_error("render", {"model.rvm", "--diff", "d.png"}, "--diff");
  expect_usage_error("render", {"model.rvm", "--frame", "3"}, "--frame");  // without --path
  expect_usage_error("render", {"model.rvm", "--path", "p.json", "--frame", "300"}, "--frame");
  expect_usage_error("render", {"model.rvm", "--path", "p.json", "--frame", "5", "--frames", "5"}, "--frame");
  expect_usage_error("render", {"model.rvm", "--path", "p.json", "--frame", "-1"}, "--frame");
  expect_usage_error("render", {"model.rvm", "--path", "p.json", "--view", "v.json"}, "--view");
  for (const char* option : {"--fit", "--ortho"})
    expect_usage_error("render", {"model.rvm", option, "--view", "v.json"}, "--view");
  expect_usage_error("render", {"model.rvm", "--from", "top", "--path", "p.json"}, "--path");
  expect_usage_error("render", {"model.rvm", "--from", "above"}, "above");
  for (const char* bad : {"", "z", "z<", "w<3", "z=3", "z<3 miles", "z<nan", "z<3m4"})
    expect_usage_error("render", {"model.rvm", "--section", bad}, "z<12.3");
  expect_usage_error("render", {"model.rvm", "--out", "image.gif"}, "ends in .png");
}

}  // namespace
}  // namespace sightline::tests::command_line_test
