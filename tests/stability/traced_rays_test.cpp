// The ray tracer against the reference in 113 bits. Hundreds of millions of rays are the tool's, `sightline-stability
// --trace`.
#include "sightline/apps/bench/stability/traced_rays.h"

#include <string>

#include <gtest/gtest.h>

#include "sightline/tests/support/effort.h"

namespace sightline::bench::traced_rays_test {
namespace {

const std::int64_t kRays = tests::repeated(50'000, 25);  // a million together in a long run

/// What scenes are made of, and a seed.
using Shard = std::tuple<TracedKind, std::uint64_t>;
class TracedRays : public testing::TestWithParam<Shard> {};

TEST_P(TracedRays, AreRight) {
  const auto [kind, seed] = GetParam();
  const TracedCounts counts = trace_rays(kind, kRays, seed);
  EXPECT_EQ(counts.rays, kRays);
  EXPECT_EQ(counts.wrong, 0);
  EXPECT_LE(counts.worst, 1.0);
  EXPECT_GT(counts.hits, kRays / 2);
  // Rays are aimed at edges, too. Bad triangles nearly are edges.
  EXPECT_LT(counts.grazes, kind == core::Kind::kMesh ? kRays : kRays / 3);
  EXPECT_LT(counts.ties, kRays / 100);
  for (const std::string& example : counts.examples) ADD_FAILURE() << example;
}

std::string shard_name(const testing::TestParamInfo<Shard>& info) {
  const auto [kind, seed] = info.param;
  return (kind ? std::string(core::name_of(*kind)) : "mixed") + std::to_string(seed);
}

INSTANTIATE_TEST_SUITE_P(Kinds, TracedRays,
                         testing::Combine(testing::Values(core::Kind::kCylinder, core::Kind::kSnout,
                                                          core::Kind::kCircularTorus, core::Kind::kRectangularTorus,
                                                          core::Kind::kSphere, core::Kind::kSphericalDish,
                                                          core::Kind::kEllipticalDish, core::Kind::kBox,
                                                          core::Kind::kPyramid, core::Kind::kMesh),
                                          testing::Values(1u)),
                         shard_name);
// Each has a ray that the judge misjudged: one that grazes a surface where it touches another, or meets a solid whose
// placement is nearly flat.
INSTANTIATE_TEST_SUITE_P(NarrowGrazes, TracedRays,
                         testing::Values(Shard(core::Kind::kRectangularTorus, 5085),
                                         Shard(core::Kind::kRectangularTorus, 5445),
                                         Shard(core::Kind::kCircularTorus, 5527)),
                         shard_name);
INSTANTIATE_TEST_SUITE_P(Everything, TracedRays,
                         testing::Combine(testing::Values(TracedKind()), testing::Range<std::uint64_t>(1, 11)),
                         shard_name);

}  // namespace
}  // namespace sightline::bench::traced_rays_test
