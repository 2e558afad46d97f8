// Groups of many loose parts without some of them: whole parts, near ones that stay.
#include "sightline/lod/internal/loose_parts.h"

#include <set>

#include <gtest/gtest.h>

#include "sightline/lod/mesh_levels.h"
#include "sightline/tests/lod/mesh_samples.h"

namespace sightline::tests::loose_parts_test {
namespace {

core::Mesh bar(const core::vec3& size) {
  core::Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.push_back(size * core::vec3(i & 1, i >> 1 & 1, i >> 2));
  mesh.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                  2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return mesh;
}

/// Bars beside each other.
core::Mesh grating(int count, float pitch) {
  const core::Mesh one = bar({0.005f, 1.0f, 0.03f});
  core::Mesh mesh = one;
  for (int i = 1; i < count; ++i) mesh = joined(std::move(mesh), one, {pitch * float(i), 0.0f, 0.0f});
  return mesh;
}

/// Which bars are left, by the places of their corners. Each must be whole.
std::set<int> bars_left(const core::Mesh& mesh, const std::vector<std::uint32_t>& corners, std::size_t all) {
  std::vector<std::size_t> triangles(all);
  for (std::size_t i = 0; i < corners.size(); i += 3) ++triangles[corners[i] / 8];
  std::set<int> left;
  for (std::size_t i = 0; i < all; ++i) {
    EXPECT_TRUE(triangles[i] == 0 || triangles[i] == 12) << i;
    if (triangles[i] != 0) left.insert(int(i));
  }
  EXPECT_LE(corners.size(), mesh.indices.size());
  return left;
}

TEST(LooseParts, LeaveANeighbourOfEachThatGoes) {
  for (const int count : {2, 3, 10, 60}) {
    SCOPED_TRACE(count);
    const core::Mesh mesh = grating(count, 0.03f);
    const std::vector<std::uint8_t> locked(mesh.positions.size(), 0);
    const std::size_t half = std::size_t(count + 1) / 2;
    const auto kept = lod::without_loose_parts(mesh.positions, mesh.indices, locked, 12 * half);
    const std::set<int> left = bars_left(mesh, kept, std::size_t(count));
    EXPECT_EQ(left.size(), half);
    for (int i = 0; i < count; ++i) EXPECT_TRUE(left.count(i) || left.count(i - 1) || left.count(i + 1)) << i;
  }
}

TEST(LooseParts, KeepWhatIsLockedOrAsked) {
  const core::Mesh mesh = grating(10, 0.03f);
  std::vector<std::uint8_t> locked(mesh.positions.size(), 0);
  for (const std::size_t i : {1, 2, 3, 4}) locked[8 * i + 5] = 1;
  const auto kept = lod::without_loose_parts(mesh.positions, mesh.indices, locked, 0);
  const std::set<int> left = bars_left(mesh, kept, 10);
  for (const int i : {1, 2, 3, 4}) EXPECT_TRUE(left.count(i)) << i;
  EXPECT_FALSE(left.count(0)) << "bar 1 stands for it";
  EXPECT_EQ(bars_left(mesh, lod::without_loose_parts(mesh.positions, mesh.indices, locked, 9 * 12), 10).size(), 9u);
}

TEST(LooseParts, AreNoneWhereNoneCanGo) {
  const core::Mesh one = grating(1, 1.0f), two = grating(2, 1.0f), many = grating(300, 0.03f);
  const auto without = [](const core::Mesh& mesh, std::uint8_t lock, std::size_t target) {
    return lod::without_loose_parts(mesh.positions, mesh.indices, std::vector(mesh.positions.size(), lock), target);
  };
  EXPECT_TRUE(without(one, 0, 0).empty());
  EXPECT_TRUE(without(two, 1, 0).empty());
  EXPECT_TRUE(without(two, 0, 24).empty()) << "as few as asked";
  EXPECT_FALSE(without(two, 0, 0).empty());
  EXPECT_TRUE(without(many, 0, 0).empty()) << "too many to compare";
}

/// The nearest goes first: of two pairs, the closer one.
TEST(LooseParts, GoNearOnesFirst) {
  core::Mesh mesh = grating(2, 0.5f);
  mesh = joined(std::move(mesh), grating(2, 0.1f), {5.0f, 0.0f, 0.0f});
  const std::vector<std::uint8_t> locked(mesh.positions.size(), 0);
  const std::set<int> left = bars_left(mesh, lod::without_loose_parts(mesh.positions, mesh.indices, locked, 36), 4);
  EXPECT_EQ(left.size(), 3u);
  EXPECT_TRUE(left.count(0) && left.count(1));
}

#if SIGHTLINE_HAS_MESHOPT
/// Collapses alone make the flat bars shrink at no error that they see, by metres.
TEST(LooseParts, KeepGratingsNear) {
  const core::Mesh mesh = grating(400, 0.03f);
  const lod::MeshLevels levels = lod::build_levels(mesh);
  std::size_t within = 0;
  for (const lod::Cluster& cluster : levels.clusters) {
    const auto simplified = [&](std::uint32_t group) { return levels.groups[group].error <= 0.1f; };
    if ((cluster.made_by == core::kNone || simplified(cluster.made_by)) &&
        (cluster.goes_into == core::kNone || !simplified(cluster.goes_into)))
      within += cluster.index_count;
  }
  EXPECT_LT(within, mesh.indices.size() / 4) << "a bar of three stands for its neighbours";
}
#endif

}  // namespace
}  // namespace sightline::tests::loose_parts_test
