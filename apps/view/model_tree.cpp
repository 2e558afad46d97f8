#include "sightline/apps/view/model_tree.h"

#include <algorithm>
#include <utility>

#include "sightline/apps/common/named_parts.h"

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
  named_ = false;
  error_.clear();
  if (query.text.empty()) return rows_.clear_filter();
  auto found = index_.find(query, kMostRows);
  if (found && found->count == 0 && !query.regular_expression) {
    const auto named = by_rule(query.text);
    if (named && !named->nodes.empty()) return show_named(*named);
    if (!named) found = tl::unexpected(named.error());
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
  matches_.nodes.resize(std::min(kMostRows, matches_.count));
  named_ = true;
  rows_.set_filter(matches_.nodes);
}

core::Expected<core::FoundNodes> ModelTree::find_named(const NameQuery& query) {
  find(query);
  if (query.text.empty()) return core::fail("expected the name of a part");
  if (!error_.empty()) return core::fail(error_);
  if (!query.regular_expression) {
    auto found = nodes_named(query.text);
    if (found) show_named(*found);
    return found;
  }
  if (matches_.count == 0) return core::fail("no part fits \"" + query.text + "\"");
  return core::FoundNodes{matches_.nodes, core::NodeMatch::kPattern};
}

core::Expected<core::FoundNodes> ModelTree::nodes_named(const std::string& text) {
  release_scene();
  auto found = by_rule(text);
  return found && found->nodes.empty() ? find_parts(*scene_, {{"", text}}) : found;
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
