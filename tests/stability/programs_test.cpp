#include <gtest/gtest.h>

#include "sightline/apps/bench/stability/glsl_rays.h"
#include "sightline/tests/support/glslang.h"

namespace sightline::bench::programs_test {
namespace {

TEST(RayPrograms, AreValid) {
  tests::expect_valid(GlslRays::all_programs());
}

}  // namespace
}  // namespace sightline::bench::programs_test
