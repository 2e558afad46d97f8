#include "sightline/apps/view/selection_level.h"

#include <algorithm>
#include <unordered_set>

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

std::vector<std::vector<core::ItemId>> groups_of(const core::Scene& scene, std::span<const core::ItemId> items,
                                                 SelectionLevel level, bool whole,
                                                 const std::function<bool(core::ItemId)>& counts) {
  std::vector<std::vector<core::ItemId>> groups;
  std::unordered_set<std::uint32_t> seen;
  for (const core::ItemId item : items) {
    const core::NodeId node = node_at(scene, item, level);
    if (node.valid() && !seen.insert(node.index).second) continue;
    std::vector<core::ItemId> group = node.valid() ? items_below(scene, node) : std::vector{item};
    std::erase_if(group, [&](core::ItemId one) { return !counts(one); });
    if (!whole || std::includes(items.begin(), items.end(), group.begin(), group.end()))
      groups.push_back(std::move(group));
  }
  return groups;
}

}  // namespace sightline::apps
