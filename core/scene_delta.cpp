#include "sightline/core/scene_delta.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace sightline::core {
namespace {

std::vector<std::uint32_t> united(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
  std::vector<std::uint32_t> both;
  both.reserve(a.size() + b.size());
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return both;
}

std::vector<std::uint32_t> without(const std::vector<std::uint32_t>& all, const std::vector<std::uint32_t>& some) {
  std::vector<std::uint32_t> rest;
  std::set_difference(all.begin(), all.end(), some.begin(), some.end(), std::back_inserter(rest));
  return rest;
}

}  // namespace

void SceneDelta::append(const SceneDelta& later) {
  changed = without(united(changed, without(later.changed, inserted)), later.removed);
  removed = united(removed, without(later.removed, inserted));
  inserted = united(without(inserted, later.removed), later.inserted);
  materials = united(materials, later.materials);
}

void SceneSubscription::Inbox::merge_last() {
  const SceneDelta last = std::move(deltas.back());
  deltas.pop_back();
  deltas.back().append(last);
}

void SceneSubscription::Inbox::push(const SceneDelta& delta, std::uint64_t commit) {
  newest = commit;
  deltas.push_back(delta);
  while (deltas.size() > 1 && deltas[deltas.size() - 2].size() <= 2 * deltas.back().size()) merge_last();
}

SceneDelta SceneSubscription::take() {
  if (!inbox_) return {};
  inbox_->followed = std::exchange(inbox_->taken, inbox_->newest);
  if (inbox_->deltas.empty()) return {};
  while (inbox_->deltas.size() > 1) inbox_->merge_last();
  SceneDelta all = std::move(inbox_->deltas[0]);
  inbox_->deltas.clear();
  return all;
}

}  // namespace sightline::core
