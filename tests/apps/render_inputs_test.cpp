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
  for (const char* option : {"--out", "--ids", "--ids-json", "--depth", "--json"})
    expect_failure("render", with({option, bad}), bad, true);
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
    expect_failure("render", with({"--view", file}), file, true);
  }
  expect_failure("render", with({"--view", path("missing.json")}), path("missing.json"), true);
  render(with({"--view", write("view.json", R"({"eye":[0,0,0],)" + rest + "}")}));
}

TEST_F(RenderInputs, RefusesBadPaths) {
  const std::string first = R"({"t":1,"eye":[0,0,0],"target":[1,0,0],"fovy_deg":60})";
  for (const std::string& text : {std::string(), std::string("{}"),
                                  R"({"keys":[)" + first + R"(,{"t":0,"eye":[0,1,0],"target":[1,0,0]}],"near":1})",
                                  R"({"keys":[)" + first + "]}"}) {
    SCOPED_TRACE(text);
    const std::string file = write("path.json", text);
    expect_failure("render", with({"--path", file}), file, true);
  }
  const std::string good = write("path.json", R"({"keys":[)" + first + R"(],"near":0.1})");
  render(with({"--path", good, "--frame", "299"}));
}

TEST_F(RenderInputs, DrawsAnEmptyScene) {
  render({write("nothing.stl", tests::stl_text({})), "--size", "16x16", "--out", path("a.png"), "--ids", path("b.png"),
          "--depth", path("c.pfm")});
  for (const char* file : {"a.png", "b.png", "c.pfm"}) EXPECT_GT(fs::file_size(path(file)), 0u) << file;
}

}  // namespace
}  // namespace sightline::tests::render_inputs_test
