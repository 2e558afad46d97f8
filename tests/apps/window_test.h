// Tests of programs that open windows, on a virtual display.
#pragma once

#include <chrono>
#include <csignal>
#include <functional>
#include <thread>

#include "sightline/tests/apps/render_test.h"

namespace sightline::tests {

inline constexpr auto kPatience = std::chrono::seconds(60);

/// Asks again and again; false when it never came true.
inline bool comes_true(const std::function<bool()>& question) {
  for (const auto end = std::chrono::steady_clock::now() + kPatience; std::chrono::steady_clock::now() < end;) {
    if (question()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return false;
}

/// Each test has a display of its own, 800 x 600 pixels of 24 bits. Skipped without Xvfb. Windows has a display.
class WindowTest : public RenderTest {
 protected:
  /// Skips where a program is not installed, or fails where drawing is required.
  void need(const std::string& program, const Args& args) const {
    const Outcome outcome = run_program(program, args);
    if (outcome.code >= 0) return;
    if (gl_required()) FAIL() << outcome;
    GTEST_SKIP() << outcome;
  }

#if __has_include(<spawn.h>)
  void SetUp() override {
    RenderTest::SetUp();
    if (!IsSkipped() && !HasFatalFailure()) need("Xvfb", {"-version"});
    if (IsSkipped() || HasFatalFailure()) return;
    wayland_.set(std::nullopt);
    // GLX unloads its driver, and what that keeps for ever can then no longer be told from leaks.
    const auto options = core::platform::environment("ASAN_OPTIONS");
    sanitizer_.set((options ? *options + ":" : "") + "detect_leaks=0");
    // `timeout` ends the display should this process come to a sudden end; -noreset: it refuses nobody when its last
    // client has gone.
    display_ = start_program("timeout",
                             {"300", "Xvfb", "-displayfd", "1", "-screen", "0", "800x600x24", "-nolisten", "tcp",
                              "-noreset", "-fbdir", path("")},
                             "xvfb");
    ASSERT_NE(display_.pid, 0);
    std::string number;
    comes_true([&] {
      number = read_bytes(display_.out);
      if (number.find('\n') != std::string::npos) return true;
      siginfo_t ended{};
      return waitid(P_PID, id_t(display_.pid), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid != 0;
    });
    number = number.substr(0, number.find('\n'));
    ASSERT_FALSE(number.empty()) << "no virtual display: " << read_bytes(display_.err);
    name_.set(":" + number);
  }
  void TearDown() override {
    if (display_.pid != 0) {
      kill(display_.pid, SIGTERM);
      wait_for(display_);
    }
    RenderTest::TearDown();
  }

 private:
  const Variable name_{"DISPLAY"}, wayland_{"WAYLAND_DISPLAY"}, sanitizer_{"ASAN_OPTIONS"};
  Child display_;
#endif
};

}  // namespace sightline::tests
