#include <algorithm>

#include "sightline/apps/common/named_parts.h"
#include "sightline/apps/common/tree_walk.h"
#include "sightline/apps/view/actions.h"
#include "sightline/core/internal/sort_unique.h"

namespace sightline::apps {
namespace {

std::vector<core::ItemId> items_below_all(const std::vector<core::NodeId>& nodes, const core::Scene& scene) {
  std::vector<core::ItemId> items;
  for (const core::NodeId node : nodes) {
    const std::vector<core::ItemId> below = items_below(scene, node);
    items.insert(items.end(), below.begin(), below.end());
  }
  core::sort_unique(items);
  return items;
}

}  // namespace

Done find_parts(const std::string& text, Session& session, Messages& messages) {
  const auto found = session.tree.find_named({text});
  if (!found) return tl::unexpected(found.error());
  messages.tell(words_of_parts(session.scene(), text, *found));
  return {};
}

Done select_found(const std::string&, Session& session, Messages& messages) {
  ModelTree& tree = session.tree;
  if (!tree.named()) {
    const NameQuery query = tree.query();
    const auto found = tree.find_named(query);
    if (!found) return tl::unexpected(found.error());
    messages.tell(words_of_parts(session.scene(), query.text, *found));
  }
  return session.document.select(items_below_all(tree.matches(), session.scene()));
}

core::Expected<std::vector<core::ItemId>> items_named(const std::string& text, Session& session, Messages& messages) {
  const auto found = session.tree.nodes_named(text);
  if (!found) return tl::unexpected(found.error());
  if (found->nodes.size() > 1) messages.tell(words_of_parts(session.scene(), text, *found));
  std::vector<core::ItemId> items = items_below_all(found->nodes, session.scene());
  if (items.empty()) return core::fail("there are no items below \"" + text + "\"");
  return items;
}

Done toggle_part(const std::string& text, Session& session, Messages& messages) {
  Document& document = session.document;
  const PartName part = part_of(text);
  const bool numbered = text.empty() || part.node != text;  // as views have it
  const auto items = numbered ? core::Expected<std::vector<core::ItemId>>(session.items_of(part))
                              : items_named(text, session, messages);
  if (!items) return tl::unexpected(items.error());
  if (items->empty()) return core::fail("the model has no items below \"" + text + "\"");
  const auto hidden = [&](core::ItemId item) { return document.is(item, Document::kHidden); };
  return std::all_of(items->begin(), items->end(), hidden) ? document.show(*items) : document.hide(*items);
}

}  // namespace sightline::apps
