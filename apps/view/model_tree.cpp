#include "sightline/apps/view/model_tree.h"

#include <chrono>
#include <utility>

namespace sightline::apps {
namespace {

constexpr std::size_t kMostRows = 200000;  // of matches; nobody reads on

}  // namespace

ModelTree::ModelTree(const core::Scene& scene) : indexing_([this, &scene] { index_ = NameIndex(scene); }) {
  rows_.reset(scene);
}

void ModelTree::find(const NameQuery& query) {
  if (indexing_.joinable()) indexing_.join();
  const auto begin = std::chrono::steady_clock::now();
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
  find_ms_ = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

void ModelTree::reveal(core::NodeId node) {
  revealed_ = rows_.reveal(node);
}

std::optional<std::size_t> ModelTree::take_revealed() {
  return std::exchange(revealed_, std::nullopt);
}

}  // namespace sightline::apps
