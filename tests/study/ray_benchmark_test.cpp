#include <map>
#include <set>

#include <gtest/gtest.h>

#include "sightline/apps/study/rays/benchmark.h"
#include "sightline/apps/study/rays/generated_meshes.h"

namespace sightline::study::rays::ray_benchmark_test {
namespace {

TEST(GeneratedMeshes, HaveAboutTheTrianglesAskedFor) {
  for (const std::size_t n : {12u, 1000u, 30'000u}) {
    EXPECT_NEAR(double(make_scan(n).indices.size() / 3), double(n), 0.1 * double(n));
  }
  EXPECT_NEAR(double(make_scattered(30'000).indices.size() / 3), 30'000.0, 3000.0);
}

/// Each edge, as a pair of positions, has as many triangles on one side as on the other.
TEST(GeneratedMeshes, ScansAreClosed) {
  const GeneratedMesh mesh = make_scan(3000);
  const auto key = [&](std::uint32_t i) {
    const core::vec3& p = mesh.positions[i];
    return std::array<float, 3>{p.x, p.y, p.z};
  };
  std::map<std::pair<std::array<float, 3>, std::array<float, 3>>, int> edges;
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const auto a = key(mesh.indices[i]), b = key(mesh.indices[i % 3 == 2 ? i - 2 : i + 1]);
    ++edges[{a, b}];
    --edges[{b, a}];
  }
  for (const auto& [edge, sum] : edges) ASSERT_EQ(sum, 0);
}

TEST(RayBenchmark, MeasuresAllAndTheyAgree) {
  const GeneratedMesh mesh = make_scattered(3000);
  const TriangleSet triangles(mesh.positions, mesh.indices);
  std::set<std::string> steps;
  const auto made =
      run_benchmark("scattered", triangles, {96, 64}, 1, [&](const std::string& step) { steps.insert(step); });
  ASSERT_TRUE(made);
  const Benchmark& b = *made;
  EXPECT_EQ(b.traversals.size(), 16u);
  EXPECT_EQ(b.structures.size(), kStructures);
  EXPECT_EQ(steps.size(), 1u + 16u + 3u * 16u);
  EXPECT_EQ(b.rays[0], 96u * 64u);
  EXPECT_EQ(b.rays[1], b.rays[2]);
  EXPECT_GT(b.hits, 0.05);
  EXPECT_LT(b.hits, 0.95);
  for (const StructureRun& s : b.structures) EXPECT_GT(s.bytes, 0u) << name_of(s.structure);
  for (const TraversalRun& r : b.traversals) {
    EXPECT_EQ(r.disagreements, 0u) << r.traversal->name;
    EXPECT_GT(r.nodes, 0.0) << r.traversal->name;
    EXPECT_GT(r.triangles, 0.0) << r.traversal->name;
    for (const double share : {r.lanes_rows, r.lanes_tiles, r.balance_rows, r.balance_tiles}) {
      EXPECT_GT(share, 0.0) << r.traversal->name;
      EXPECT_LE(share, 1.0) << r.traversal->name;
    }
  }
  EXPECT_EQ(b.find("kd standard")->nodes, b.find("kd 8-byte standard")->nodes);
  EXPECT_EQ(b.find("no such"), nullptr);
}

}  // namespace
}  // namespace sightline::study::rays::ray_benchmark_test
