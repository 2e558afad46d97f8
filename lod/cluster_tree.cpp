#include "sightline/lod/internal/cluster_tree.h"

#include <algorithm>
#include <limits>

namespace sightline::lod {
namespace {

constexpr std::size_t kMostRoots = 32;  // more are held together

/// Roots that stand for so many each of the given ones, which are neighbours.
std::vector<std::uint32_t> held_together(MeshLevels& levels, std::span<const std::uint32_t> roots) {
  std::vector<std::uint32_t> holders;
  for (std::size_t first = 0; first < roots.size(); first += kMostRoots) {
    const std::uint32_t number =
        join_clusters(levels, roots.subspan(first, std::min(kMostRoots, roots.size() - first)));
    levels.groups[number].error = std::numeric_limits<float>::infinity();
    holders.push_back(std::uint32_t(levels.clusters.size()));
    levels.clusters.push_back(
        {std::uint32_t(levels.indices.size()), 0, number, core::kNone, levels.groups[number].box});
  }
  return holders;
}

}  // namespace

std::uint32_t join_clusters(MeshLevels& levels, std::span<const std::uint32_t> members) {
  const auto number = std::uint32_t(levels.groups.size());
  ClusterGroup group;
  group.first_member = std::uint32_t(levels.members.size());
  group.member_count = std::uint32_t(members.size());
  levels.members.insert(levels.members.end(), members.begin(), members.end());
  for (const std::uint32_t member : members) {
    Cluster& cluster = levels.clusters[member];
    cluster.goes_into = number;
    group.box.grow(cluster.box);
    if (cluster.made_by == core::kNone) continue;
    const ClusterGroup& child = levels.groups[cluster.made_by];
    group.box.grow(child.box);
    group.error = std::max(group.error, child.error);
    group.angle = std::max(group.angle, child.angle);
  }
  levels.groups.push_back(group);
  return number;
}

void list_roots(MeshLevels& levels) {
  std::vector<std::uint32_t> roots;
  for (std::uint32_t i = 0; i < levels.clusters.size(); ++i)
    if (levels.clusters[i].goes_into == core::kNone) roots.push_back(i);
  while (roots.size() > kMostRoots) roots = held_together(levels, roots);
  levels.first_root = std::uint32_t(levels.members.size());
  levels.members.insert(levels.members.end(), roots.begin(), roots.end());
}

}  // namespace sightline::lod
