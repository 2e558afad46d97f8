// What sightline-render makes of bad views, bad paths and outputs that cannot be written. Each run has a context first.
#include "sightline/tests/apps/render_test.h"

namespace sightline::tests::render_inputs_test {
namespace {

class RenderInputs : public RenderTest {
 protected:
  void SetUp() override {
    RenderTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    model = write("triangle.stl", tests::stl_text({{{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}}}));
  }
  Args with(const Args& more) const {
    Args args = {model, "--size", "16x16"};
    args.insert(args.end(), more.begin(), more.end());
    return args;
  }
  std::string model;
};

TEST_F(RenderInputs, RefusesUnwritableOutputs) {
  const std::string bad = unwritable("a.png"), good = path("good.png");
  for (const char* option : {"--out", "--ids", "--ids-json", "--json"})
    expect_failure("render", with({option, bad}), bad, true);
  expect_failure("render", with({"--depth", unwritable("a.pfm")}), unwritable("a.pfm"), true);
  render(with({"--out", good}));
  expect_failure("render", with({"--compare", good, "--diff", bad}), bad, true);
  const std::string folder = path("folder");
  fs::create_directories(folder);
  expect_failure("render", with({"--out", folder}), folder, true);
}

TEST_F(RenderInputs, RefusesBadViews) {
  const std::string rest = R"("target":[1,0,0],"fovy_deg":60,"near":0.1)";
  const std::vector<std::string> bad = {
      "",
      "no JSON",
      "[1,2]",
      "{}",
      "{" + rest + "}",
      R"({"eye":[0,0,0],)" + rest,
      R"({"eye":"here",)" + rest + "}",
      R"({"eye":[0,0],)" + rest + "}",
      R"({"eye":[1,0,0],)" + rest + "}",
      R"({"eye":[0,0,0],"ortho_height":3,)" + rest + "}",
      R"({"eye":[0,0,0],"far":0.01,)" + rest + "}",
      R"({"eye":[0,0,0],"layers":-1,)" + rest + "}",
      R"({"eye":[0,0,0],"section_mode":"most",)" + rest + "}",
      R"({"eye":[0,0,0],"sections":[{"n":[0,0,0],"d":0}],)" + rest + "}",
      R"({"eye":[0,0,0],"sections":[{"n":[0,0,1]}],)" + rest + "}",
      R"({"eye":[0,0,0],"target":[1,0,0],"fovy_deg":0,"near":0.1})",
      R"({"eye":[0,0,0],"target":[1,0,0],"fovy_deg":60,"near":-0.1})",
      R"({"eye":[0,0,0],"target":[1,0,0],"ortho_height":-1,"near":0.1})",
  };
  for (const std::string& text : bad) {
    SCOPED_TRACE(text);
    const std::string file = write("view.json", text);
    expect_failure("render", with({"--out", path("a.png"), "--view", file}), file, true);
  }
  expect_failure("render", with({"--out", path("a.png"), "--view", path("missing.json")}), path("missing.json"), true);
  render(with({"--out", path("a.png"), "--view", write("view.json", R"({"eye":[0,0,0],)" + rest + "}")}));
}

TEST_F(RenderInputs, RefusesBadPaths) {
  const std::string first = R"({"t":1,"eye":[0,0,0],"target":[1,0,0],"fovy_deg":60})";
  for (const std::string& text : {std::string(), std::string("{}"),
                                  R"({"keys":[)" + first + R"(,{"t":0,"eye":[0,1,0],"target":[1,0,0]}],"near":1})",
                                  R"({"keys":[)" + first + "]}"}) {
    SCOPED_TRACE(text);
    const std::string file = write("path.json", text);
    expect_failure("render", with({"--out", path("a.png"), "--path", file}), file, true);
  }
  const std::string good = write("path.json", R"({"keys":[)" + first + R"(],"near":0.1})");
  render(with({"--out", path("a.png"), "--path", good, "--frame", "299"}));
}

TEST_F(RenderInputs, RefusesWhatNobodyWouldSeeBeforeAnyWork) {
  expect_usage_error("render", {path("none.stl"), "--size", "16x16"}, "--out is required");
  expect_usage_error("trace", {path("none.stl"), "--size", "16x16"}, "--out is required");
  for (const char* tool : {"render", "trace"}) {
    for (const char* wrong : {"a.gif", "a.PNG.tif", "a.pfm"})
      expect_usage_error(tool, {path("none.stl"), "--out", path(wrong)}, "expected a name that ends in .png");
    expect_usage_error(tool, {path("none.stl"), "--depth", path("a.png")}, "expected a name that ends in .pfm");
  }
  expect_usage_error("replay", {path("none.stl"), "--plot", path("a.png")}, "expected a name that ends in .svg");
  render(with({"--out", path("a.PNG")}));
}

TEST_F(RenderInputs, SectionsThatLeaveNothingAreErrors) {
  const std::string view = write("view.json", R"({"eye":[0,-5,0],"target":[0,0,0],"fovy_deg":60,"near":0.1,
      "sections":[{"n":[1,0,0],"d":-2},{"n":[0,0,1],"d":0}]})");
  for (const char* tool : {"render", "trace"})
    for (const Args& cut : {Args{"--section", "z>3000"}, Args{"--section", "z<1", "--section", "x<-1mm"},
                            Args{"--view", view}, Args{"--section", "z>3000", "--translate", "0,0,9000"}}) {
      Args args = with({"--out", path("cut.png")});
      args.insert(args.end(), cut.begin(), cut.end());
      expect_failure(tool, args, "the sections leave nothing of the model, from 0 0 0 to 1 0 1 m", true);
      EXPECT_FALSE(fs::exists(path("cut.png")));
      args.push_back("--allow-empty");
      const Outcome asked = run(tool, args);
      EXPECT_EQ(asked.code, 0) << asked;
      EXPECT_NE(asked.err.find("shows nothing"), std::string::npos) << asked;
      fs::remove(path("cut.png"));
    }
  const Outcome hidden = run("render", with({"--out", path("a.png"), "--hide", "*"}));
  EXPECT_EQ(hidden.code, 0) << hidden;
  EXPECT_NE(hidden.err.find("warning: the image shows nothing"), std::string::npos) << hidden;
  EXPECT_EQ(run("render", with({"--out", path("a.png"), "--section", "z<0.5"})).err, "");
}

TEST_F(RenderInputs, SectionsCutFramesOfPaths) {
  const std::string flight = write("flight.json", R"({"keys":[{"t":0,"eye":[0.4,-5,0.4],"target":[0.4,0,0.4],
      "fovy_deg":60},{"t":1,"eye":[0.4,-6,0.4],"target":[0.4,0,0.4]}],"near":0.1})");
  for (const char* folder : {"whole", "cut"}) {
    Args args = with({"--path", flight, "--fps", "1", "--write-frames", path(folder)});
    if (std::string(folder) == "cut") args.insert(args.end(), {"--section", "z<0.2"});
    render(args);
  }
  EXPECT_NE(read_bytes(path("whole/frame-000001.png")), read_bytes(path("cut/frame-000001.png")));
  expect_failure("render", with({"--path", flight, "--write-frames", path("none"), "--section", "z>3000"}),
                 "the sections leave nothing", true);
}

TEST_F(RenderInputs, DrawsAnEmptyScene) {
  render({write("nothing.stl", tests::stl_text({})), "--size", "16x16", "--out", path("a.png"), "--ids", path("b.png"),
          "--depth", path("c.pfm")});
  for (const char* file : {"a.png", "b.png", "c.pfm"}) EXPECT_GT(fs::file_size(path(file)), 0u) << file;
}

}  // namespace
}  // namespace sightline::tests::render_inputs_test
