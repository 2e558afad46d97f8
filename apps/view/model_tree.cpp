#include "sightline/apps/view/model_tree.h"

#include <utility>

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
  if (!query_.text.empty()) find(NameQuery(query_));
}

void ModelTree::find(const NameQuery& query) {
  release_scene();
  query_ = query;
  matches_ = {};
  error_.clear();
  if (query.text.empty()) {
    rows_.clear_filter();
  } else if (auto found = index_.find(query, kMostRows); found) {
    matches_ = std::move(*found);
    rows_.set_filter(matches_.nodes);
  } else {
    error_ = found.error().message;  // the rows stay
  }
}

void ModelTree::reveal(core::NodeId node) {
  revealed_ = rows_.reveal(node);
}

std::optional<std::size_t> ModelTree::take_revealed() {
  return std::exchange(revealed_, std::nullopt);
}

}  // namespace sightline::apps
