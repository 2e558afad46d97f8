// Random parameters of every kind through the shaders; the millions are the tool's, `sightline-stability --fuzz`.
#include "sightline/apps/bench/stability/fuzz.h"

#include <string>

#include <gtest/gtest.h>

#include "sightline/tests/support/gl_test.h"

namespace sightline::bench::fuzz_test {
namespace {

class Fuzz : public testing::TestWithParam<core::Kind> {};

TEST_P(Fuzz, ShaderAndReferenceAgree) {
  constexpr std::uint64_t kSeed = 1;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  auto shaders = GlslRays::create();
  if (!shaders) {
    if (!tests::may_skip(shaders.error().message)) FAIL() << shaders.error().message;
    GTEST_SKIP() << shaders.error().message;
  }
  const auto counts = fuzz(*shaders, GetParam(), 20'000, kSeed);
  ASSERT_TRUE(counts) << counts.error().message;
  EXPECT_EQ(counts->not_finite, 0);
  EXPECT_EQ(counts->outside, 0);
  EXPECT_EQ(counts->disagree, 0);
  EXPECT_GT(counts->hits, 4000);
  if (!HasFailure()) return;
  for (const std::string& example : counts->examples) ADD_FAILURE() << example;
}

INSTANTIATE_TEST_SUITE_P(Kinds, Fuzz,
                         testing::Values(core::Kind::kCylinder, core::Kind::kSnout, core::Kind::kCircularTorus,
                                         core::Kind::kRectangularTorus, core::Kind::kSphere, core::Kind::kSphericalDish,
                                         core::Kind::kEllipticalDish, core::Kind::kBox, core::Kind::kPyramid),
                         [](const auto& kind) { return std::string(core::name_of(kind.param)); });

}  // namespace
}  // namespace sightline::bench::fuzz_test
