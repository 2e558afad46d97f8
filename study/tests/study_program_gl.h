// Tests that let sightline-study draw.
#pragma once

#include "sightline/gl/context.h"
#include "sightline/study/tests/study_program.h"
#include "sightline/tests/support/no_gl.h"

namespace sightline::tests {

/// Skips, with the library's own words, or fails where there is no EGL or OpenGL (no_gl.h).
class StudyGlTest : public StudyTest {
 protected:
  void SetUp() override {
    StudyTest::SetUp();
    const auto context = gl::Context::create_offscreen();
    if (context) return;
    if (!may_skip(context.error().message)) FAIL() << context.error().message;
    GTEST_SKIP() << context.error().message;
  }
};

}  // namespace sightline::tests
