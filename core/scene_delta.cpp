#include "sightline/core/scene_delta.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace sightline::core {
namespace {

template <class Id>
std::vector<Id> united(const std::vector<Id>& a, const std::vector<Id>& b) {
  std::vector<Id> both;
  both.reserve(a.size() + b.size());
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return both;
}

template <class Id>
std::vector<Id> without(const std::vector<Id>& all, const std::vector<Id>& some) {
  std::vector<Id> rest;
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
