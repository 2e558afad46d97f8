#include "sightline/apps/view/model_tree.h"

#include <algorithm>
#include <span>
#include <utility>

#include "sightline/analysis/query/conditions.h"
#include "sightline/apps/common/tree_walk.h"

namespace sightline::apps {
namespace {

constexpr std::size_t kMostRows = 200000;  // of matches; nobody reads on

}  // namespace

ModelTree::ModelTree(const core::Scene& scene) : scene_(&scene) {
  follow_scene();
}

void ModelTree::release_scene() {
  if (indexing_.joinable()) indexing_.join();
}

void ModelTree::follow_scene() {
  release_scene();
  indexing_ = std::jthread([this] { index_ = NameIndex(*scene_); });
  rows_.reset(*scene_);
  if (query_.text.empty()) return;
  if (named_)
    (void)find_named(NameQuery(query_));
  else
    find(NameQuery(query_));
}

void ModelTree::find(const NameQuery& query) {
  release_scene();
  query_ = query;
  matches_ = {};
  items_.reset();
  named_ = false;
  error_.clear();
  if (query.text.empty()) return rows_.clear_filter();
  auto found = index_.find(query, kMostRows);
  if (found && found->count == 0 && !query.regular_expression) {
    const auto named = by_rule(query.text);
    if (named && !named->nodes.empty()) return show_named(*named);
    if (!named) found = tl::unexpected(named.error());
    if (named && query::is_query(query.text)) {
      if (const auto shown = show_items_of(query.text); !shown) error_ = shown.error().message;
      return;
    }
  }
  if (!found) {
    error_ = found.error().message;  // the rows stay
    return;
  }
  matches_ = std::move(*found);
  rows_.set_filter(matches_.nodes);
}

void ModelTree::show_named(const core::FoundNodes& found) {
  matches_ = {found.nodes, found.nodes.size()};
  named_ = true;
  rows_.set_filter(std::span(matches_.nodes).first(std::min(kMostRows, matches_.count)));
}

/// Shows the nodes of items for which conditions hold.
core::Expected<void> ModelTree::show_items_of(const std::string& conditions) {
  auto items = query::find_items(*scene_, conditions);
  if (!items) return tl::unexpected(items.error());
  core::FoundNodes found;
  for (const core::ItemId item : *items)
    if (const core::NodeId node = scene_->node_of(item); found.nodes.empty() || found.nodes.back() != node)
      found.nodes.push_back(node);
  show_named(found);
  matches_.count = items->size();
  items_ = std::move(*items);
  return {};
}

core::Expected<std::string> ModelTree::find_named(const NameQuery& query) {
  find(query);
  if (query.text.empty()) return core::fail("expected the name of a part");
  if (!error_.empty()) return core::fail(error_);
  if (query.regular_expression) {
    if (matches_.count == 0) return core::fail("no part fits \"" + query.text + "\"");
    return words_of_parts(*scene_, query.text, {matches_.nodes, core::NodeMatch::kPattern});
  }
  const auto named = by_rule(query.text);
  if (!named) return tl::unexpected(named.error());
  if (!named->nodes.empty()) return show_named(*named), words_of_parts(*scene_, query.text, *named);
  return named_items(*scene_, query.text).map([](const NamedItems& found) { return found.words; });
}

bool ModelTree::find_letters() {
  if (matches_.count == 0 || items_) return false;
  if (matches_.count == matches_.nodes.size()) return true;
  auto all = index_.find(query_, matches_.count);
  if (all) matches_ = std::move(*all);
  return all.has_value();
}

core::Expected<NamedItems> ModelTree::items_named(const std::string& text) {
  release_scene();
  const auto found = by_rule(text);
  if (!found) return tl::unexpected(found.error());
  return found->nodes.empty() ? named_items(*scene_, text) : items_of_parts(*scene_, text, *found);
}

std::vector<core::ItemId> ModelTree::items() const {
  return items_ ? *items_ : items_below(*scene_, matches_.nodes);
}

core::Expected<core::FoundNodes> ModelTree::by_rule(const std::string& text) const {
  const core::NodeCondition whole{"", text};
  auto found = core::find_nodes(*scene_, scene_->root(), {&whole, 1});
  if (!found || !found->nodes.empty()) return found;
  const auto of_key = index_.condition_of(text);
  return of_key ? core::find_nodes(*scene_, scene_->root(), {&*of_key, 1}) : found;
}

void ModelTree::reveal(core::NodeId node) {
  revealed_ = rows_.reveal(node);
}

std::optional<std::size_t> ModelTree::take_revealed() {
  return std::exchange(revealed_, std::nullopt);
}

}  // namespace sightline::apps
