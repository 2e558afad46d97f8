#include "sightline/apps/view/tree_states.h"

namespace sightline::apps {

void TreeStates::follow(const TreeRows& rows, const core::Scene& scene, const Document& document) {
  if (resets_ == rows.resets() && version_ == document.solid_version() && items_ == scene.item_count()) return;
  resets_ = rows.resets();
  version_ = document.solid_version();
  items_ = scene.item_count();
  before_.assign(rows.place_count() + 1, {});
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item) {
    if (!scene.contains_item(item)) continue;
    const auto range = rows.range(scene.node_of(item));
    if (!range) continue;
    Below& own = before_[range->first + 1];
    ++own.items;
    own.shown += document.shown(item);
  }
  for (std::size_t i = 1; i < before_.size(); ++i) {
    before_[i].items += before_[i - 1].items;
    before_[i].shown += before_[i - 1].shown;
  }
}

TreeStates::Below TreeStates::below(const TreeRows& rows, core::NodeId node) const {
  const auto range = rows.range(node);
  if (!range || range->second >= before_.size()) return {};
  const Below &first = before_[range->first], &end = before_[range->second];
  return {end.items - first.items, end.shown - first.shown};
}

}  // namespace sightline::apps
