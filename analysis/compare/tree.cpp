#include "sightline/analysis/compare/internal/tree.h"

#include <algorithm>

namespace sightline::compare {

Tree::Tree(const Revision& revision) {
  const core::Scene& scene = *revision.scene;
  std::vector<std::uint32_t> position;  // by node index
  scene.for_each_node(revision.top, [&](core::NodeId node, const core::Affine&, bool, std::uint32_t, core::MaterialId) {
    const auto here = std::uint32_t(nodes.size());
    if (position.size() <= node.index) position.resize(node.index + 1);
    position[node.index] = here;
    const std::uint32_t above = here == 0 ? 0 : position[scene.parent(node).index];
    nodes.push_back(node);
    parent.push_back(above);
    depth.push_back(here == 0 ? 0 : depth[above] + 1);
    // Myers' skew-binary jump pointers ("An applicative random-access stack", 1983).
    const auto far = [&](std::uint32_t from) { return depth[from] - depth[jump[from]]; };
    const bool joins = here != 0 && far(above) == far(jump[above]);
    jump.push_back(joins ? jump[jump[above]] : above);
    end.push_back(here + 1);
    first_item.push_back(std::uint32_t(items.size()));
    for (core::ItemId i = scene.first_item(node); i != core::kNoItem; i = scene.next_item(i)) {
      items.push_back(i);
      node_of_item.push_back(here);
    }
  });
  first_item.push_back(std::uint32_t(items.size()));
  for (auto node = std::uint32_t(nodes.size()); node-- > 1;) end[parent[node]] = std::max(end[parent[node]], end[node]);
}

}  // namespace sightline::compare
