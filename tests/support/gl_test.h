// Fixture for tests that need a GL context.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "sightline/gl/context.h"
#include "sightline/gl/functions.h"
#include "sightline/tests/support/no_gl.h"

namespace sightline::tests {

/// Is called with the function table of every test's context; see tests/shaders/listed_sources.h. Null: nothing is.
inline void (*watch_functions)(gl::Functions&) = nullptr;

/// Each test gets an offscreen debug context of its own, current on the test's thread, and fails when an error is left
/// in it at the end. Without EGL or a driver the test is skipped with the reason, or fails (no_gl.h).
///
/// GL objects of the test body die before the context. Members of a derived fixture do not: reset them in a TearDown()
/// that then calls GlTest::TearDown().
class GlTest : public ::testing::Test {
 protected:
  void SetUp() override {
    gl::ContextOptions options;
    options.debug = true;
    auto made = gl::Context::create_offscreen(options);
    if (made) {
      context.emplace(std::move(*made));
      if (watch_functions) watch_functions(const_cast<gl::Functions&>(context->functions()));
      return;
    }
    if (!may_skip(made.error().message)) FAIL() << made.error().message;
    GTEST_SKIP() << made.error().message;
  }

  void TearDown() override {
    if (!context) return;
    (void)context->make_current();  // an engine may have left nothing current
    for (const std::string& error : context->take_errors()) ADD_FAILURE() << "GL error left: " << error;
    context.reset();
  }

  const gl::Functions& gl() const { return context->functions(); }

  std::optional<gl::Context> context;
};

}  // namespace sightline::tests
