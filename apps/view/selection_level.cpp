#include "sightline/apps/view/selection_level.h"

#include <algorithm>
#include <unordered_map>

#include "sightline/apps/common/tree_walk.h"

namespace sightline::apps {

core::NodeId node_at(const core::Scene& scene, core::ItemId item, SelectionLevel level) {
  if (level == SelectionLevel::kItem) return {};
  core::NodeId node = scene.node_of(item);
  if (level == SelectionLevel::kFile) {
    while (node != scene.root() && scene.parent(node) != scene.root()) node = scene.parent(node);
    return node;
  }
  const core::NodeId part = core::part_of(scene, node);
  if (level == SelectionLevel::kPart || !part.valid()) return part;
  const core::NodeId assembly = core::part_of(scene, scene.parent(part));
  return assembly.valid() ? assembly : part;
}

Taken taken_at(const core::Scene& scene, core::ItemId item, SelectionLevel level) {
  const core::NodeId node = node_at(scene, item, level);
  return {item, node, node.valid() ? items_below(scene, node) : std::vector{item}};
}

std::vector<Taken> groups_of(const core::Scene& scene, std::span<const core::ItemId> items, SelectionLevel level,
                             std::size_t most) {
  std::vector<Taken> groups;
  std::unordered_map<std::uint32_t, std::size_t> group_of;  // by the node's index
  for (const core::ItemId item : items) {
    const core::NodeId node = node_at(scene, item, level);
    if (node.valid()) {
      const auto [known, is_new] = group_of.try_emplace(node.index, groups.size());
      if (!is_new) {
        groups[known->second].items.push_back(item);
        continue;
      }
    }
    groups.push_back({item, node, {item}});
    if (groups.size() == most) break;
  }
  return groups;
}

std::vector<std::vector<core::ItemId>> taken_by(const core::Scene& scene, std::span<const core::ItemId> items,
                                                SelectionLevel level, bool whole,
                                                const std::function<bool(core::ItemId)>& counts) {
  std::vector<std::vector<core::ItemId>> taken;
  for (const Taken& group : groups_of(scene, items, level)) {
    std::vector<core::ItemId> all = group.node.valid() ? items_below(scene, group.node) : group.items;
    std::erase_if(all, [&](core::ItemId item) { return !counts(item); });
    if (!whole || std::includes(group.items.begin(), group.items.end(), all.begin(), all.end()))
      taken.push_back(std::move(all));
  }
  return taken;
}

}  // namespace sightline::apps
