// Tests that draw through sightline-render.
#pragma once

#include <tuple>

#include "sightline/tests/apps/tool_test.h"
#include "sightline/tests/support/environment.h"
#include "sightline/tests/support/no_gl.h"

namespace sightline::tests {

/// Tools draw with OpenGL, unless they are told otherwise. Skips, with the tool's own words, or fails where it finds no
/// EGL or OpenGL (no_gl.h).
class RenderTest : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    core::platform::set_environment("SIGHTLINE_RENDERER", "gl");
    static const Outcome probe = run("render", {write("probe.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n"), "--size",
                                                "8x8", "--out", path("probe.png")});
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

using ModelView = std::tuple<std::string, std::string>;  // names of a model and of a view of it

/// Real plants, each from three views, for INSTANTIATE_TEST_SUITE_P.
inline auto huldra_views() {
  return ::testing::Combine(::testing::Values("HA-PIPE", "HA-MECH", "WD1-PSUP"),
                            ::testing::Values("over", "near", "ortho"));
}
inline std::string name_of_view(const ::testing::TestParamInfo<ModelView>& info) {
  std::string name = std::get<0>(info.param) + "_" + std::get<1>(info.param);
  std::erase(name, '-');
  return name;
}

}  // namespace sightline::tests
