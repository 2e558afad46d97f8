// Tools that draw by rays: where there is no OpenGL, and what they show beside it.
#include "sightline/tests/apps/render_test.h"

namespace sightline::tests::render_rays_test {
namespace {

/// EGL finds no driver.
class WithoutOpenGl : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    fs::rename(plant(1000, 1), path("a.rvm"));
  }
  static bool tells(const Outcome& outcome) {
    return outcome.err.find("note: there is no OpenGL") != std::string::npos;
  }

 private:
  Variable context_{"SIGHTLINE_CONTEXT", "egl"}, drivers_{"__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent"},
      renderer_{"SIGHTLINE_RENDERER", "auto"};
};

TEST_F(WithoutOpenGl, ImagesAreThere) {
  for (const Args& looks : {Args{}, Args{"--plain"}, Args{"--section", "z<5"}, Args{"--ortho", "--from", "front"}}) {
    Args args = {path("a.rvm"), "--size", "200x120", "--out", path("a.png"), "--ids", path("ids.png"), "--json", "-"};
    args.insert(args.end(), looks.begin(), looks.end());
    const Outcome drawn = run("render", args);
    ASSERT_EQ(drawn.code, 0) << drawn;
    EXPECT_TRUE(tells(drawn)) << drawn;
    EXPECT_TRUE(json::parse(drawn.out).value()["renderer"].get<std::string>().starts_with("rays")) << drawn;
    EXPECT_GT(fs::file_size(path("a.png")), 2000u);
  }
  const Outcome explained = run("render", {path("a.rvm"), "--size", "64x64", "--explain"});
  EXPECT_EQ(explained.code, 0) << explained;
  EXPECT_NE((explained.out + explained.err).find("images by rays"), std::string::npos) << explained;
}

TEST_F(WithoutOpenGl, WhatNeedsItSaysSo) {
  const Args image = {path("a.rvm"), "--size", "64x64", "--out", path("a.png")};
  for (const Args& wants : {Args{"--renderer", "gl"}, Args{"--hatching", "0.5"}, Args{"--culler", "gpu"}}) {
    Args args = image;
    args.insert(args.end(), wants.begin(), wants.end());
    const Outcome drawn = run("render", args);
    EXPECT_NE(drawn.code, 0) << drawn;
    EXPECT_NE(drawn.err.find("EGL"), std::string::npos) << drawn;
    EXPECT_EQ(drawn.error_lines().size(), 1u) << drawn;
  }
}

TEST_F(WithoutOpenGl, FlightsAndSuitesAreDrawn) {
  const Outcome flown = run("replay", {path("a.rvm"), "--size", "160x90", "--frames", "3", "--json", "-"});
  ASSERT_EQ(flown.code, 0) << flown;
  EXPECT_TRUE(tells(flown)) << flown;
  EXPECT_NE(flown.out.find("rays"), std::string::npos) << flown;
  const std::string suite = write("suite.json", R"({"size":"160x90","limits":{"max":0,"ids":0},
      "models":[{"name":"a","files":["a.rvm"],"views":[{"name":"whole"},{"name":"people","looks":"standard"}]}]})");
  const Outcome first = run("regress", {suite, "--out", path("out"), "--quiet"});
  EXPECT_NE(first.code, 0) << first;  // there are no references yet
  const Outcome accepted = run("regress", {suite, "--out", path("out"), "--quiet", "--resume", "--accept"});
  EXPECT_EQ(accepted.code, 0) << accepted;
  const Outcome again = run("regress", {suite, "--out", path("again"), "--quiet"});
  EXPECT_EQ(again.code, 0) << again;
}

class RenderRays : public RenderTest {};

/// What accuracy.md states of images by rays.
TEST_F(RenderRays, ShowWhatOpenGlShows) {
  const std::string model = plant(3000, 5);
  for (const Args& looks : {Args{}, Args{"--plain"}, Args{"--section", "z<5"}, Args{"--samples", "1"}}) {
    Args gl = {model, "--size", "480x270", "--out", path("gl.png"), "--renderer", "gl"};
    Args rays = {model,       "--size",       "480x270", "--out", path("rays.png"), "--renderer", "rays",
                 "--compare", path("gl.png"), "--max",   "255",   "--json",         "-"};
    gl.insert(gl.end(), looks.begin(), looks.end());
    rays.insert(rays.end(), looks.begin(), looks.end());
    render(gl);
    const Json found = json::parse(render(rays).out).value()["compare"];
    EXPECT_LE(found["pixels"].get<int>(), 480 * 270 / 33) << found.dump();
    EXPECT_LE(found["flip"]["mean"].get<double>(), 0.004) << found.dump();
  }
}

}  // namespace
}  // namespace sightline::tests::render_rays_test
