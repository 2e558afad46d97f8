// Groups of clusters: complete, small, connected where they can be, and better than chance.
#include "sightline/lod/internal/cluster_groups.h"

#include <map>
#include <random>

#include <gtest/gtest.h>

namespace sightline::tests::cluster_groups_test {
namespace {

using lod::Contact;

std::vector<Contact> of_a_grid(std::uint32_t width, std::uint32_t height) {
  std::vector<Contact> contacts;
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; ++x) {
      if (x + 1 < width) contacts.push_back({y * width + x, y * width + x + 1, 8});
      if (y + 1 < height) contacts.push_back({y * width + x, (y + 1) * width + x, 8});
    }
  return contacts;
}

std::map<std::uint32_t, std::uint32_t> sizes(const std::vector<std::uint32_t>& groups) {
  std::map<std::uint32_t, std::uint32_t> sizes;
  for (const std::uint32_t group : groups) ++sizes[group];
  return sizes;
}

TEST(ClusterGroups, TakeEveryClusterOnce) {
  for (std::uint32_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto count = std::uint32_t(1 + random() % 60), most = std::uint32_t(1 + random() % 9);
    std::vector<Contact> contacts;
    for (std::uint32_t a = 0; a < count; ++a)
      for (std::uint32_t b = a + 1; b < count; ++b)
        if (random() % count < 3) contacts.push_back({a, b, 1 + std::uint32_t(random() % 20)});
    const auto groups = lod::group_clusters(count, contacts, most);
    ASSERT_EQ(groups.size(), count);
    std::uint32_t next = 0;
    for (const std::uint32_t group : groups) {
      ASSERT_LE(group, next) << "numbered by their first clusters";
      next = std::max(next, group + 1);
    }
    for (const auto& [group, size] : sizes(groups)) EXPECT_LE(size, most) << group;
    EXPECT_EQ(groups, lod::group_clusters(count, contacts, most));
  }
}

TEST(ClusterGroups, ShareManyEdges) {
  const auto contacts = of_a_grid(32, 32);
  const auto groups = lod::group_clusters(32 * 32, contacts, 8);
  std::uint64_t inside = 0, all = 0;
  for (const Contact& contact : contacts) {
    all += contact.edges;
    if (groups[contact.a] == groups[contact.b]) inside += contact.edges;
  }
  EXPECT_GT(double(inside) / double(all), 0.5) << "rows of eight have 0.45, squares of eight 0.6";
}

TEST(ClusterGroups, PutLonelyClustersTogether) {
  const auto groups = lod::group_clusters(20, {}, 8);
  EXPECT_EQ(sizes(groups).size(), 3u);
}

}  // namespace
}  // namespace sightline::tests::cluster_groups_test
