// sightline-stability through the shaders, with few rays of every case (docs/reference/accuracy.md), and what it
// refuses.
#include "sightline/tests/apps/render_test.h"

namespace sightline::tests::stability_test {
namespace {

using Stability = RenderTest;

TEST_F(Stability, ShadersAgreeWithTheReference) {
  const Outcome outcome = run("stability", {"--rays", "10", "--path", "glsl", "--json", path("glsl.json")});
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_TRUE(json::parse(read_bytes(path("glsl.json"))));
}

TEST_F(Stability, RefusesPathsThatItDoesNotHave) {
  expect_usage_error("stability", {"--path", "float"}, "float not in");
}

}  // namespace
}  // namespace sightline::tests::stability_test
