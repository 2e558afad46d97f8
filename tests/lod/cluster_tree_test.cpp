// Groups of the tree: what they hold and how large their errors and boxes are, and that there are few roots.
#include "sightline/lod/internal/cluster_tree.h"

#include <limits>

#include <gtest/gtest.h>

#include "sightline/tests/lod/mesh_samples.h"

namespace sightline::tests::cluster_tree_test {
namespace {

using lod::Cluster;
using lod::MeshLevels;

core::Aabb any_box(MeshRandom& random) {
  core::Aabb box;
  for (int i = 0; i < 2; ++i) {
    const double z = between(random, -1, 1), y = between(random, -1, 1), x = between(random, -1, 1);
    const core::vec3 p(x, y, z);
    box.grow({p, p});
  }
  return box;
}

void expect_equal(const core::Aabb& a, const core::Aabb& b) {
  EXPECT_EQ(a.min, b.min);
  EXPECT_EQ(a.max, b.max);
}

MeshLevels any_clusters(std::uint32_t count, MeshRandom& random) {
  MeshLevels levels;
  for (std::uint32_t i = 0; i < count; ++i) {
    levels.clusters.push_back({3 * i, 3, core::kNone, core::kNone, any_box(random)});
    for (std::uint32_t k = 0; k < 3; ++k) levels.indices.push_back(k);
  }
  return levels;
}

TEST(ClusterTree, JoinsClustersIntoTheLeastThatTheyAllow) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(seed);
    MeshRandom random(seed);
    MeshLevels levels = any_clusters(8, random);
    for (std::uint32_t i = 0; i < 4; ++i) {
      levels.groups.push_back({float(between(random, 0, 1)), float(between(random, 0, 1)), any_box(random), i, 1});
      levels.members.push_back(i);
      levels.clusters[i].goes_into = i;
      levels.clusters[4 + i].made_by = random() % 3 == 0 ? core::kNone : std::uint32_t(random() % 4);
    }
    const std::vector<std::uint32_t> members{6, 4, 7};
    lod::ClusterGroup expected{0.0f, 0.0f, {}, 4, 3};
    for (const std::uint32_t member : members) {
      expected.box.grow(levels.clusters[member].box);
      const std::uint32_t made_by = levels.clusters[member].made_by;
      if (made_by == core::kNone) continue;
      expected.box.grow(levels.groups[made_by].box);
      expected.error = std::max(expected.error, levels.groups[made_by].error);
      expected.angle = std::max(expected.angle, levels.groups[made_by].angle);
    }
    ASSERT_EQ(lod::join_clusters(levels, members), 4u);
    ASSERT_EQ(levels.groups.size(), 5u);
    expect_equal(levels.groups[4].box, expected.box);
    EXPECT_EQ(levels.groups[4].error, expected.error);
    EXPECT_EQ(levels.groups[4].angle, expected.angle);
    EXPECT_EQ(levels.groups[4].first_member, 4u);
    EXPECT_EQ(levels.groups[4].member_count, 3u);
    EXPECT_EQ(levels.members, (std::vector<std::uint32_t>{0, 1, 2, 3, 6, 4, 7}));
    for (std::uint32_t i = 4; i < 8; ++i) EXPECT_EQ(levels.clusters[i].goes_into, i == 5 ? core::kNone : 4u);
  }
}

/// Groups of 32 neighbours, and of these, until there are at most 32.
TEST(ClusterTree, HoldsManyRootsTogether) {
  for (const std::uint32_t count : {0u, 1u, 31u, 32u, 33u, 64u, 65u, 1000u, 1024u, 1025u, 2100u}) {
    SCOPED_TRACE(count);
    MeshRandom random(count);
    MeshLevels levels = any_clusters(count, random);
    lod::list_roots(levels);
    std::vector<std::uint32_t> roots;
    for (std::uint32_t i = 0; i < count; ++i) roots.push_back(i);
    std::uint32_t group = 0, member = 0, made = count;
    while (roots.size() > 32) {
      std::vector<std::uint32_t> above;
      for (std::size_t i = 0; i < roots.size(); ++group, ++made) {
        ASSERT_LT(group, levels.groups.size());
        ASSERT_LT(made, levels.clusters.size());
        const lod::ClusterGroup& holder = levels.groups[group];
        EXPECT_EQ(holder.error, std::numeric_limits<float>::infinity());
        EXPECT_EQ(holder.first_member, member);
        EXPECT_EQ(holder.member_count, std::min(std::size_t(32), roots.size() - i));
        core::Aabb box;
        for (std::uint32_t k = 0; k < holder.member_count; ++k, ++i, ++member) {
          ASSERT_EQ(levels.members[member], roots[i]);
          EXPECT_EQ(levels.clusters[roots[i]].goes_into, group);
          box.grow(levels.clusters[roots[i]].box);
        }
        expect_equal(holder.box, box);
        const Cluster& cluster = levels.clusters[made];
        EXPECT_EQ(cluster.first_index, levels.indices.size());
        EXPECT_EQ(cluster.index_count, 0u);
        EXPECT_EQ(cluster.made_by, group);
        expect_equal(cluster.box, box);
        above.push_back(made);
      }
      roots = above;
    }
    EXPECT_EQ(levels.groups.size(), group);
    EXPECT_EQ(levels.clusters.size(), made);
    EXPECT_EQ(levels.first_root, member);
    EXPECT_EQ(std::vector<std::uint32_t>(levels.members.begin() + member, levels.members.end()), roots);
  }
}

}  // namespace
}  // namespace sightline::tests::cluster_tree_test
