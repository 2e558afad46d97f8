// Tests that draw through sightline-render.
#pragma once

#include "sightline/tests/apps/tool_test.h"
#include "sightline/tests/support/no_gl.h"

namespace sightline::tests {

/// Skips, with the tool's own words, or fails where it finds no EGL or OpenGL (no_gl.h).
class RenderTest : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    static const Outcome probe =
        run("render", {write("probe.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n"), "--size", "8x8"});
    if (probe.code == 0) return;
    if (!may_skip(probe.err)) FAIL() << probe;
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
