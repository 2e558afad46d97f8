// Every traversal against brute force.
#include <cstdlib>

#include <gtest/gtest.h>

#include "sightline/apps/study/rays/traversals.h"
#include "sightline/tests/study/rays_scenes.h"

namespace sightline::study::rays::rays_test {
namespace {

using namespace tests;

/// Checks the promises of all traversals on one ray. False: something failed.
bool agree(const Structures& structures, const Ray& ray, const std::string& where) {
  const Hit expected = structures.triangles.brute_force(ray);
  for (const Traversal& t : traversals()) {
    Counters counters;
    const Hit nearest = t.nearest(structures, ray), counted = t.count(structures, ray, counters);
    EXPECT_EQ(nearest.triangle, expected.triangle) << t.name << ", " << where << ", " << describe(ray);
    EXPECT_EQ(nearest.t, expected.t) << t.name << ", " << where << ", " << describe(ray);
    EXPECT_EQ(counted, nearest) << t.name << ", " << where << ", " << describe(ray);
    EXPECT_EQ(t.any(structures, ray), bool(expected)) << t.name << ", " << where << ", " << describe(ray);
    if (expected) {
      EXPECT_GT(counters.nodes, 0u) << t.name;
      EXPECT_GT(counters.triangles, 0u) << t.name;
    }
    if (testing::Test::HasFailure()) return false;
  }
  return true;
}

TEST(Rays, AllTraversalsFindWhatBruteForceFinds) {
  constexpr std::uint64_t kSeed = 20110215;
  const char* wanted = std::getenv("SIGHTLINE_STUDY_RAYS");  // per scene
  const int count = wanted != nullptr ? std::atoi(wanted) : 4000;
  Random random(kSeed);
  for (const Mesh& mesh : scenes(random)) {
    const TriangleSet triangles = mesh.set();
    const Structures structures(triangles);
    RaySource rays(structures, random);
    int hits = 0;
    for (int i = 0; i < count; ++i) {
      const Ray ray = rays.next();
      ASSERT_TRUE(agree(structures, ray, mesh.name + ", seed " + std::to_string(kSeed) + ", ray " + std::to_string(i)));
      hits += bool(triangles.brute_force(ray));
    }
    const bool hittable = mesh.name != "empty" && mesh.name != "one point";
    EXPECT_EQ(hits > count / 10, hittable) << mesh.name << ": " << hits << " rays hit";
  }
}

TEST(Rays, ThatAreNotFiniteHitNothing) {
  const Mesh mesh = sphere(16, 8);
  const TriangleSet triangles = mesh.set();
  const Structures structures(triangles);
  for (const Ray& ray : bad_rays()) {
    EXPECT_FALSE(triangles.brute_force(ray));
    agree(structures, ray, "not finite");
  }
}

TEST(Rays, NothingPassesBetweenTrianglesThatShareAnEdge) {
  constexpr std::uint64_t kSeed = 7;
  Random random(kSeed);
  const Mesh mesh = sphere(31, 17);
  const TriangleSet triangles = mesh.set();
  for (int i = 0; i < 20000; ++i) {
    const dvec3 from = random_point(random, -0.3, 0.3);
    const std::uint32_t k = pick(random, mesh.indices.size() / 3) * 3;
    const dvec3 a(mesh.positions[mesh.indices[k]]), b(mesh.positions[mesh.indices[k + 1]]);
    const dvec3 through = a + (i % 3 == 0 ? 0.0 : uniform(random, 0.0, 1.0)) * (b - a);
    const Hit hit = triangles.brute_force({from, through - from});
    ASSERT_TRUE(hit) << "seed " << kSeed << ", ray " << i;
    ASSERT_NEAR(hit.t, 1.0, 1e-6) << "seed " << kSeed << ", ray " << i;
  }
}

TEST(Rays, HitsAreWhereTheyAreKnownToBe) {
  Mesh mesh;
  mesh.triangle({0, 0, 1}, {2, 0, 1}, {0, 2, 1});
  mesh.triangle({0, 0, 5}, {2, 0, 5}, {0, 2, 5});
  mesh.triangle({0, 0, 1}, {2, 0, 1}, {0, 2, 1});
  const TriangleSet triangles = mesh.set();
  EXPECT_EQ(triangles.brute_force({{0.5, 0.5, 0}, {0, 0, 0.5}}), (Hit{2.0, 0}));
  EXPECT_EQ(triangles.brute_force({{0.5, 0.5, 3}, {0, 0, 1}}), (Hit{2.0, 1}));
  EXPECT_EQ(triangles.brute_force({{0.5, 0.5, 3}, {0, 0, -1}}), (Hit{2.0, 0}));
  EXPECT_EQ(triangles.brute_force({{0.5, 0.5, 3}, {0, 0, -1}, 2.0}), (Hit{2.0, 0}));
  EXPECT_FALSE(triangles.brute_force({{0.5, 0.5, 3}, {0, 0, -1}, 1.999}));
  EXPECT_FALSE(triangles.brute_force({{1.5, 1.5, 0}, {0, 0, 1}}));
  EXPECT_FALSE(triangles.brute_force({{0.5, 0.5, 6}, {0, 0, 1}}));
}

/// The order in which the dissertation's graph 6-4 has them, but for each single ray.
TEST(Rays, FewerNodesAreVisitedWhereTheSearchRemembersMore) {
  constexpr std::uint64_t kSeed = 64;
  Random random(kSeed);
  const Mesh mesh = soup(random, 3000, 0.1);
  const TriangleSet triangles = mesh.set();
  const Structures structures(triangles);
  const auto nodes = [&](const std::string& name, const Ray& ray) {
    for (const Traversal& t : traversals()) {
      if (t.name != name) continue;
      Counters counters;
      t.count(structures, ray, counters);
      return counters.nodes;
    }
    ADD_FAILURE() << "no traversal " << name;
    return std::uint64_t(0);
  };
  std::uint64_t restart_sum = 0, short_stack_sum = 0, push_down_sum = 0, standard_sum = 0, ropes_sum = 0;
  for (int i = 0; i < 1000; ++i) {
    const Ray ray{random_point(random, -2.0, 2.0), random_point(random, -1.0, 1.0)};
    const auto restart = nodes("kd restart", ray), push_down = nodes("kd push-down", ray);
    const auto short_stack = nodes("kd short-stack", ray), both = nodes("kd PD & SS", ray);
    const auto standard = nodes("kd standard", ray), ropes = nodes("kd ropes", ray);
    ASSERT_EQ(standard, nodes("kd 8-byte standard", ray));
    ASSERT_EQ(ropes, nodes("kd ropes++", ray));
    ASSERT_LE(standard, both) << "seed " << kSeed << ", ray " << i;
    ASSERT_LE(both, short_stack) << "seed " << kSeed << ", ray " << i;
    ASSERT_LE(short_stack, restart) << "seed " << kSeed << ", ray " << i;
    ASSERT_LE(push_down, restart) << "seed " << kSeed << ", ray " << i;
    restart_sum += restart, short_stack_sum += short_stack, push_down_sum += push_down;
    standard_sum += standard, ropes_sum += ropes;
  }
  EXPECT_LT(ropes_sum, standard_sum);
  EXPECT_LT(standard_sum, short_stack_sum);
  EXPECT_LT(short_stack_sum, restart_sum);
  EXPECT_LT(push_down_sum, restart_sum);
}

}  // namespace
}  // namespace sightline::study::rays::rays_test
