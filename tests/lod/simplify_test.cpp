// One step of simplification: as few triangles as are asked for, and locked vertices keep their places.
#include "sightline/lod/internal/simplify.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "sightline/lod/stored_levels.h"
#include "sightline/tests/lod/mesh_samples.h"

namespace sightline::tests::simplify_test {
namespace {

constexpr std::uint32_t kCells = 24, kSide = kCells + 1;

std::vector<std::uint32_t> simplified(const core::Mesh& mesh, const std::vector<std::uint8_t>& locked,
                                      std::size_t target) {
  return lod::simplify(mesh.positions, mesh.indices, locked, target);
}

/// Locks each vertex with some chance.
std::vector<std::uint8_t> any_locks(const core::Mesh& mesh, double share, MeshRandom& random) {
  std::vector<std::uint8_t> locked(mesh.positions.size());
  for (std::uint8_t& lock : locked) lock = between(random, 0, 1) < share;
  return locked;
}

TEST(Simplify, ReachesItsTarget) {
  if (!lod::builds_levels()) GTEST_SKIP() << "this build has no meshoptimizer";
  for (const double scale : {1e-3, 1.0, 1e6}) {
    core::Mesh mesh = terrain(kCells, 1.0);
    for (core::vec3& p : mesh.positions) p = float(scale) * (p + core::vec3(100.0f, -50.0f, 20.0f));
    for (const std::size_t target : {1000u, 576u, 300u, 200u})
      for (const double share : {0.0, 0.03, 0.1}) {
        SCOPED_TRACE(testing::Message() << scale << ' ' << target << ' ' << share);
        MeshRandom random(target);
        const std::size_t triangles = simplified(mesh, any_locks(mesh, share, random), target).size() / 3;
        EXPECT_LE(triangles, target);
        EXPECT_GE(triangles + 2, target);
      }
  }
}

/// How often each edge runs forwards, less how often it runs back: nowhere but at open borders other than 0.
std::map<std::array<std::uint32_t, 2>, int> borders(const std::vector<std::uint32_t>& corners) {
  std::map<std::array<std::uint32_t, 2>, int> borders;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::uint32_t a = corners[i], b = corners[i % 3 == 2 ? i - 2 : i + 1];
    borders[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
  }
  std::erase_if(borders, [](const auto& edge) { return edge.second == 0; });
  return borders;
}

/// Locks of the border, as groups share it, and of vertices inside, where other surfaces touch this one.
TEST(Simplify, KeepsWhatIsLocked) {
  const core::Mesh mesh = terrain(kCells, 1.0);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    MeshRandom random(seed);
    std::vector<std::uint8_t> locked = any_locks(mesh, seed % 2 ? 0.01 : 0.2, random);
    for (std::uint32_t i = 0; i < kSide; ++i)
      for (const std::uint32_t vertex : {i * kSide, i * kSide + kCells, i, kCells * kSide + i}) locked[vertex] = 1;
    const std::vector<std::uint32_t> corners = simplified(mesh, locked, 300);
    EXPECT_EQ(borders(corners), borders(mesh.indices));
    std::set<std::uint32_t> used(corners.begin(), corners.end());
    for (std::uint32_t i = 0; i < locked.size(); ++i) EXPECT_TRUE(!locked[i] || used.contains(i)) << i;
  }
}

TEST(Simplify, KeepsAllWhereAllIsLocked) {
  const core::Mesh mesh = terrain(8, 1.0);
  EXPECT_EQ(simplified(mesh, std::vector<std::uint8_t>(mesh.positions.size(), 1), 1), mesh.indices);
}

}  // namespace
}  // namespace sightline::tests::simplify_test
