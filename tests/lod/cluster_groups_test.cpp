// Groups of clusters: complete, small, connected where they can be, and better than chance.
#include "sightline/lod/internal/cluster_groups.h"

#include <algorithm>
#include <map>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "sightline/core/conventions.h"

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

std::vector<Contact> any_contacts(std::uint32_t count, std::mt19937& random) {
  std::vector<Contact> contacts;
  for (std::uint32_t a = 0; a < count; ++a)
    for (std::uint32_t b = a + 1; b < count; ++b)
      if (random() % count < 3) contacts.push_back({a, b, 1 + std::uint32_t(random() % 20)});
  return contacts;
}

/// Finds the cluster without a group that touches a group by most edges, and of several such the one that
/// touched it first; kNone: there is none.
std::uint32_t next_of(const std::vector<std::uint32_t>& group, const std::vector<std::uint32_t>& groups,
                      const std::vector<Contact>& contacts) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;  // by cluster, in the order of touching
  for (const std::uint32_t member : group)
    for (const Contact& contact : contacts) {
      if (contact.a != member && contact.b != member) continue;
      const std::uint32_t other = contact.a == member ? contact.b : contact.a;
      if (groups[other] != core::kNone) continue;
      const auto at = std::ranges::find(edges, other, &std::pair<std::uint32_t, std::uint32_t>::first);
      if (at == edges.end())
        edges.emplace_back(other, contact.edges);
      else
        at->second += contact.edges;
    }
  std::pair<std::uint32_t, std::uint32_t> best{core::kNone, 0};
  for (const auto& one : edges)
    if (one.second > best.second) best = one;
  return best.first;
}

/// Makes equal groups without lists of neighbours.
std::vector<std::uint32_t> groups_twin(std::uint32_t count, const std::vector<Contact>& contacts, std::uint32_t most) {
  std::vector<std::uint32_t> groups(count, core::kNone), lonely;
  std::uint32_t number = 0, of_lonely = core::kNone;
  for (std::uint32_t first = 0; first < count; ++first) {
    if (groups[first] != core::kNone) continue;
    if (next_of({first}, groups, contacts) == core::kNone) {
      if (lonely.size() % most == 0) of_lonely = number++;
      lonely.push_back(first);
      groups[first] = of_lonely;
      continue;
    }
    std::vector<std::uint32_t> group;
    for (std::uint32_t next = first; next != core::kNone && group.size() < most;
         next = next_of(group, groups, contacts)) {
      group.push_back(next);
      groups[next] = number;
    }
    ++number;
  }
  return groups;
}

TEST(ClusterGroups, AreThoseOfATwin) {
  for (std::uint32_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto count = std::uint32_t(1 + random() % 60), most = std::uint32_t(1 + random() % 9);
    const std::vector<Contact> contacts = any_contacts(count, random);
    ASSERT_EQ(lod::group_clusters(count, contacts, most), groups_twin(count, contacts, most));
  }
  ASSERT_EQ(lod::group_clusters(100, of_a_grid(10, 10), 8), groups_twin(100, of_a_grid(10, 10), 8)) << "equal edges";
}

TEST(ClusterGroups, TakeEveryClusterOnce) {
  for (std::uint32_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto count = std::uint32_t(1 + random() % 60), most = std::uint32_t(1 + random() % 9);
    const std::vector<Contact> contacts = any_contacts(count, random);
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
