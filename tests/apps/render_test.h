// Tests that draw through sightline-render.
#pragma once

#include <cstdlib>

#include "sightline/tests/apps/tool_test.h"

namespace sightline::tests {

/// Skips, with the tool's own words, where it finds no EGL or OpenGL; fails instead if SIGHTLINE_REQUIRE_GL is set to
/// other than 0.
class RenderTest : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    static const Outcome probe =
        run("render", {write("probe.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n"), "--size", "8x8"});
    if (probe.code == 0) return;
    const char* require = std::getenv("SIGHTLINE_REQUIRE_GL");
    const bool required = require && std::string(require) != "0";
    const bool no_gl = probe.err.find("EGL") != std::string::npos || probe.err.find("OpenGL") != std::string::npos;
    if (required || !no_gl) FAIL() << probe;
    GTEST_SKIP() << probe.err;
  }

  /// Must succeed.
  Outcome render(const Args& args) const {
    Outcome outcome = run("render", args);
    EXPECT_EQ(outcome.code, 0) << outcome;
    return outcome;
  }
};

}  // namespace sightline::tests
