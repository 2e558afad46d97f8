// sightline-view in a window of a virtual display: images and scripts. Skipped without Xvfb.
#include <chrono>

#include <png.h>

#include "sightline/tests/apps/view_window.h"

namespace sightline::tests::view_test {
namespace {

/// Items against the sky: without them the image would be of one colour.
void expect_not_empty(const std::string& file) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_file(&header, file.c_str())) << header.message;
  header.format = PNG_FORMAT_GRAY;
  std::string grey(PNG_IMAGE_SIZE(header), '\0');
  ASSERT_TRUE(png_image_finish_read(&header, nullptr, grey.data(), 0, nullptr)) << header.message;
  EXPECT_GT(std::count_if(grey.begin(), grey.end(), [&](char c) { return c != grey[0]; }), std::ptrdiff_t(100));
}

TEST_F(View, DrawsWhatRenderDraws) {
  const std::string model = plant(12000), shot = path("shot.png");
  for (const char* culler : {"auto", "linear", "gpu", "hybrid"}) {
    SCOPED_TRACE(culler);
    const Json results =
        run_json("view", {model, "--size", "320x200", "--frames", "6", "--culler", culler, "--screenshot", shot});
    EXPECT_EQ(results["frames"], 6);
    EXPECT_EQ(results["size"], Json::array({320, 200}));
    EXPECT_EQ(results["items"], 12000);
    EXPECT_GT(results["visible"], 11000);
    expect_not_empty(shot);
    const Outcome same = compare(shot, {model, "--size", "320x200"});
    EXPECT_EQ(same.code, 0) << same;
  }
}

TEST_F(View, PlaysAPath) {
  const std::string model = plant(3000), shot = path("shot.png"), tour = path("tour.json");
  ASSERT_EQ(run("replay", {model, "--no-render", "--frames", "2", "--save-path", tour}).code, 0);
  for (const Args& moved : {Args{}, Args{"--translate", "3e6,7e6,1e3"}}) {
    Args args = {model, "--size", "200x200", "--path", tour, "--frames", "4", "--screenshot", shot};
    args.insert(args.end(), moved.begin(), moved.end());
    view(args);
    expect_not_empty(shot);
    Args last = {model, "--size", "200x200", "--path", tour, "--frames", "4", "--frame", "3"};
    last.insert(last.end(), moved.begin(), moved.end());
    const Outcome same = compare(shot, last);
    EXPECT_EQ(same.code, 0) << same;
  }
}

TEST_F(View, RefusesWhatItCannotDo) {
  const std::string model = plant(1000);
  expect_usage_error("view", {model, "--frames", "0"}, "--frames");
  expect_usage_error("view", {model, "--size", "0x3"}, "--size");
  expect_failure("view", {model, "--path", path("missing.json")}, "missing.json");
  expect_failure("view", {model, "--frames", "1", "--screenshot", unwritable("a.png")}, "a.png", true);
}

TEST_F(View, RefusesWhatIsNoModel) {
  const std::string good = plant(1000);
  for (const std::string& file : bad_models()) {
    const std::string name = fs::path(file).filename().string();
    expect_failure("view", {file, "--frames", "1"}, name, true);
    expect_failure("view", {good, file, "--frames", "1"}, name, true);
  }
  for (const char* bad : {"1,2", "x", "", "nan,0,0", "1,2,3m"})
    expect_usage_error("view", {good, "--translate", bad}, "--translate");
  expect_failure("view", {good, "--translate", "1e300,0,0", "--frames", "1"}, "beyond", true);
}

/// Its last line is carried out, too.
TEST_F(ViewScript, WaitsInItsLastLine) {
  const auto begin = std::chrono::steady_clock::now();
  expect_driven("expect /pause_ms >= 0\nwait 1.5", {boxes(), "--size", kSize});
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(1500));
}

TEST_F(ViewScript, FailsWhereTheScriptExpectsOtherwise) {
  const std::string model = boxes();
  for (const auto& [script, message] :
       {std::pair<std::string, std::string>{"fit\nexpect /items = 5\n", ":2: expected /items = 5, found 4"},
        {"nonsense\n", ":1: no command nonsense"},
        {"expect /nothing = 1\n", "no /nothing"},
        {"click 3\n", "click: expected"},
        {"hide\n", "select something first"}}) {
    const Outcome outcome = drive(script, {model, "--size", "200x150"});
    EXPECT_EQ(outcome.code, 1) << outcome;
    EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome;
  }
}

TEST_F(View, SaysWhatOpenGLThereIsAndWhatItNeeds) {
  const Variable version("MESA_GL_VERSION_OVERRIDE", "3.3");
  const Outcome outcome = run("view", {plant(1000), "--frames", "1"});
  if (outcome.code == 0) GTEST_SKIP() << "not Mesa's driver";
  EXPECT_EQ(outcome.code, 1) << outcome;
  for (const char* words : {"OpenGL 4.5 core", "the display offers 3.3"})
    EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome;
}

}  // namespace
}  // namespace sightline::tests::view_test
