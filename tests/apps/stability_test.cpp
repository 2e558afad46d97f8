// sightline-stability through the shaders: few rays of every family that has no known failure (docs/stability.md).
#include "sightline/tests/apps/render_test.h"

namespace sightline::tests::stability_test {
namespace {

using Stability = RenderTest;

TEST_F(Stability, ShadersAgreeWithTheReference) {
  const Outcome outcome = run("stability", {"--rays", "10", "--path", "glsl", "--json", path("glsl.json")});
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_TRUE(json::parse(read_bytes(path("glsl.json"))));
}

}  // namespace
}  // namespace sightline::tests::stability_test
