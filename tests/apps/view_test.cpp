// sightline-view in a window of a virtual display: images, scripts, real keys. Skipped without Xvfb; keys without
// xdotool.
#include <array>
#include <chrono>
#include <csignal>
#include <optional>

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
  for (const char* display : {"", ":54321"}) {
    setenv("DISPLAY", display, 1);
    expect_failure("view", {model, "--frames", "1"}, "no window can be opened");
  }
  unsetenv("DISPLAY");
  expect_failure("view", {model, "--frames", "1"}, "no window can be opened");
}

TEST_F(View, RefusesWhatIsNoModel) {
  const std::string good = plant(1000);
  for (const std::string& file : bad_models()) {
    const std::string name = fs::path(file).filename();
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
  setenv("MESA_GL_VERSION_OVERRIDE", "3.3", 1);
  const Outcome outcome = run("view", {plant(1000), "--frames", "1"});
  unsetenv("MESA_GL_VERSION_OVERRIDE");
  if (outcome.code == 0) GTEST_SKIP() << "not Mesa's driver";
  EXPECT_EQ(outcome.code, 1) << outcome;
  for (const char* words : {"OpenGL 4.5 core", "the display offers 3.3"})
    EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome;
}

/// A window that stays open, and somebody at its keyboard.
class ViewKeys : public View {
 protected:
  void SetUp() override {
    View::SetUp();
    if (!IsSkipped() && !HasFatalFailure()) need("xdotool", {"version"});
  }
  void TearDown() override {
    if (child_.pid != 0) {
      kill(child_.pid, SIGTERM);
      wait_for(child_);
    }
    unsetenv("XDG_CONFIG_HOME");
    View::TearDown();
  }

  void open(const Args& args) {
    setenv("XDG_CONFIG_HOME", path("").c_str(), 1);
    child_ = start_program(program_of("view"), args, "view");
    ASSERT_TRUE(comes_true([&] {
      const Outcome found = xdotool({"search", "--name", " - Sightline"});
      window_ = found.out.substr(0, found.out.find('\n'));
      return !window_.empty();
    })) << read_bytes(child_.err);
    ASSERT_EQ(xdotool({"windowfocus", "--sync", window_}).code, 0);
  }
  Outcome xdotool(const Args& args) const { return run_program("xdotool", args); }
  void press(const std::string& key) const { EXPECT_EQ(xdotool({"key", key}).code, 0); }

  Child child_;
  std::string window_;
};

/// Real keys reach the commands, the window follows its size, and the screen shows the image.
TEST_F(ViewKeys, TheWindowShowsTheImageAtAnySize) {
  const std::string model = plant(3000), results = path("figures.json");
  open({model, "--size", "320x200", "--no-panels", "--no-smooth", "--plain", "--depth-shading", "0.4", "--edge-lines",
        "0.4", "--json", results});
  for (const std::array<int, 2>& wanted : {std::array{320, 200}, {200, 300}, {500, 400}}) {
    const int width = wanted[0], height = wanted[1];
    const std::string size = std::to_string(width) + "x" + std::to_string(height);
    SCOPED_TRACE(size);
    ASSERT_EQ(xdotool({"windowsize", window_, std::to_string(width), std::to_string(height)}).code, 0);
    Outcome same;
    ASSERT_TRUE(comes_true([&] {
      press("Home");
      same = compare(screen(width, height), {model, "--size", size, "--depth-shading", "0.4", "--edge-lines", "0.4"});
      return same.code == 0;
    })) << same;
  }
  xdotool({"keydown", "w"});
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  xdotool({"keyup", "w"});
  press("ctrl+q");
  const Outcome outcome = wait_for(child_);
  child_.pid = 0;
  EXPECT_EQ(outcome.code, 0) << outcome;
  const Json state = json::parse(read_bytes(results)).value();
  EXPECT_EQ(state["size"], Json::array({500, 400}));
  EXPECT_GT(state["frames"], 4);
  const Json kept = json::parse(read_bytes(path("sightline/view.json"))).value();
  EXPECT_EQ(kept["window"], Json::array({500, 400}));
  EXPECT_EQ(kept["recent"], Json::array({model}));
  EXPECT_FALSE(kept.contains("panels")) << "nobody has switched them";
}

/// The first attempt asks, the second one quits.
TEST_F(ViewKeys, QuittingAsksOnceForUnsavedViews) {
  const auto runs = [&] {
    siginfo_t ended{};
    return waitid(P_PID, id_t(child_.pid), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == 0;
  };
  const auto shown = [&] { return read_screen(path("Xvfb_screen0"), 640, 480).rgb; };
  open({plant(1000), "--size", "640x480", "--no-smooth"});
  const auto empty = shown();
  ASSERT_TRUE(comes_true([&] { return press("v"), shown() != empty; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const auto before = shown();
  press("ctrl+q");
  ASSERT_TRUE(comes_true([&] { return shown() != before; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  screen(640, 480);
  ASSERT_TRUE(runs()) << "it asks";
  press("ctrl+q");
  const Outcome outcome = wait_for(child_);
  child_.pid = 0;
  EXPECT_EQ(outcome.code, 0) << outcome;
}

/// Nothing is left of an image that is cancelled, and the window goes on as before.
TEST_F(ViewKeys, EscapeCancelsAnImage) {
  const std::string huge = path("huge.png"), after = path("after.png"), model = plant(3000);
  open({model, "--size", "320x200", "--no-panels", "--script",
        write("script.txt", "smooth\nscreenshot " + huge + " 16384x16384\nexpect /message = \"cancelled, image: " +
                                huge + "\"\nsmooth\nscreenshot " + after + "\n")});
  const auto parts = [&] {
    return std::count_if(
        fs::directory_iterator(path("")), fs::directory_iterator(),
        [](const fs::directory_entry& entry) { return entry.path().filename().string().starts_with("huge.png"); });
  };
  ASSERT_TRUE(comes_true([&] { return parts() == 1; })) << read_bytes(child_.err);
  EXPECT_TRUE(comes_true([&] {
    xdotool({"key", "Escape"});
    return fs::exists(after);
  }));
  const Outcome outcome = wait_for(child_);
  child_.pid = 0;
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_EQ(parts(), 0);
  const Outcome same = compare(after, {model, "--size", "320x200"});
  EXPECT_EQ(same.code, 0) << same;
}

}  // namespace
}  // namespace sightline::tests::view_test
