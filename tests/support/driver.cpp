// Programs of tests labelled gl hold this: whoever runs them by scripts/with_driver.sh gets no result of another
// driver.
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "sightline/gl/context.h"
#include "sightline/tests/support/no_gl.h"

namespace sightline::tests {
namespace {

/// How the names of a driver's renderers begin. What stands below zink must not be a GPU.
std::string renderer_of(const std::string& driver) {
  return driver == "zink" ? "zink (llvmpipe" : driver;
}

/// Why the driver is another one, or empty.
std::string another_than(const std::string& driver) {
  const auto made = gl::Context::create_offscreen();
  if (!made) return made.error().message;
  if (made->renderer().starts_with(renderer_of(driver))) return "";
  return "the renderer is " + made->renderer();
}

/// Skips all tests, or fails where a machine should have what drawing needs (no_gl.h).
class ChosenDriver : public ::testing::Environment {
 public:
  void SetUp() override {
    const char* driver = std::getenv("SIGHTLINE_DRIVER");
    if (!driver || !*driver) return;
    const std::string why = another_than(driver);
    if (why.empty()) return;
    if (gl_required()) FAIL() << "expected the driver " << driver << ": " << why;
    // GoogleTest prints only these words; ctest knows a skipped test by the first of them.
    GTEST_SKIP() << "[  SKIPPED ] no " << driver << ": " << why;
  }
};

const auto* const registered = ::testing::AddGlobalTestEnvironment(new ChosenDriver);

}  // namespace
}  // namespace sightline::tests
