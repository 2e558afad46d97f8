// sightline-view in a window of a virtual display, and real keys. Skipped without Xvfb or xdotool.
#include <array>
#include <chrono>
#include <csignal>

#include "sightline/tests/apps/view_window.h"

namespace sightline::tests::view_keys_test {
namespace {

/// Without a display there is no window.
TEST_F(View, NeedsADisplay) {
  const std::string model = plant(1000);
  const Variable display("DISPLAY");
  for (const std::optional<std::string>& name : {std::optional<std::string>(""), {":54321"}, {}}) {
    display.set(name);
    expect_failure("view", {model, "--frames", "1"}, "no window can be opened");
  }
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
    View::TearDown();
  }

  void open(const Args& args) {
    settings_.set(path(""));
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

  const Variable settings_{"XDG_CONFIG_HOME"};
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
}  // namespace sightline::tests::view_keys_test
