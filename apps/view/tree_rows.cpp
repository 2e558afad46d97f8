#include "sightline/apps/view/tree_rows.h"

#include <algorithm>
#include <cassert>
#include <string_view>
#include <utility>

#include "sightline/apps/common/tree_walk.h"

namespace sightline::apps {
namespace {

using core::kNoItem;
using core::kNone;
using core::NodeId;

constexpr std::size_t kGroupWords = 8;  // a cache line
constexpr std::size_t kGroup = kGroupWords * BitSet::kWordBits;

std::uint32_t rows_in_group(const BitSet& shown, std::size_t group) {
  const std::size_t end = std::min((group + 1) * kGroupWords, shown.word_count());
  int rows = 0;
  for (std::size_t w = group * kGroupWords; w < end; ++w) rows += std::popcount(shown.word(w));
  return std::uint32_t(rows);
}

}  // namespace

// --- the tree --------------------------------------------------------------------------------------------------------

void TreeRows::reset(const core::Scene& scene) {
  std::vector<NodeId> expanded;
  (filtered_ ? unfiltered_expanded_ : expanded_).for_each([&](std::size_t i) { expanded.push_back(places_[i].node); });
  const bool root_was_childless = places_.size() <= 1;

  ++resets_;
  copy_tree(scene);
  let_all_through();
  expanded_ = BitSet(places_.size());
  if (root_was_childless) expanded.push_back(scene.root());
  for (const NodeId node : expanded)
    if (const std::uint32_t i = place_of(node); i != kNone && branches_.test(i)) expanded_.set(i);
  show_all();
}

void TreeRows::copy_tree(const core::Scene& scene) {
  places_.clear();
  places_.reserve(scene.node_count());
  place_of_.clear();
  std::uint32_t parent = kNone;
  walk(
      scene,
      [&](NodeId node) {
        const auto here = std::uint32_t(places_.size());
        places_.push_back({node, parent, kNone, parent == kNone ? 0 : places_[parent].depth + 1, 0});
        if (node.index >= place_of_.size()) place_of_.resize(node.index + 1, kNone);
        place_of_[node.index] = here;
        parent = here;
      },
      [&](NodeId) {
        places_[parent].end = std::uint32_t(places_.size());
        parent = places_[parent].parent;
      });
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (scene.contains_item(item)) ++places_[place_of_[scene.node_of(item).index]].items;
  items_ = scene.item_count();
}

bool TreeRows::stale(const core::Scene& scene) const {
  return scene.node_count() != places_.size() || scene.item_count() != items_;
}

std::uint32_t TreeRows::place_of(NodeId node) const {
  if (node.index >= place_of_.size()) return kNone;
  const std::uint32_t place = place_of_[node.index];
  return place != kNone && places_[place].node == node ? place : kNone;
}

std::optional<std::pair<std::uint32_t, std::uint32_t>> TreeRows::range(NodeId node) const {
  const std::uint32_t place = place_of(node);
  return place == kNone ? std::nullopt : std::optional(std::pair(place, places_[place].end));
}

bool TreeRows::contains(NodeId node) const {
  return place_of(node) != kNone;
}

std::size_t TreeRows::memory_bytes() const {
  const auto words = members_.word_count() + branches_.word_count() + expanded_.word_count() + matches_.word_count() +
                     unfiltered_expanded_.word_count() + shown_.word_count();
  return places_.capacity() * sizeof(Place) + (place_of_.capacity() + rows_before_.capacity()) * sizeof(std::uint32_t) +
         words * sizeof(std::uint64_t);
}

// --- rows ------------------------------------------------------------------------------------------------------------

TreeRow TreeRows::row(std::size_t index) const {
  assert(index < row_count());
  const auto group =
      std::size_t(std::upper_bound(rows_before_.begin(), rows_before_.end(), index) - rows_before_.begin() - 1);
  std::size_t before = index - rows_before_[group], w = group * kGroupWords;
  for (std::size_t n; (n = std::size_t(std::popcount(shown_.word(w)))) <= before; ++w) before -= n;
  std::uint64_t word = shown_.word(w);
  for (; before > 0; --before) word &= word - 1;
  const std::size_t i = w * BitSet::kWordBits + std::size_t(std::countr_zero(word));
  const Place& place = places_[i];
  return {place.node, place.depth, place.items, branches_.test(i), expanded_.test(i), matches_.test(i)};
}

std::optional<std::size_t> TreeRows::row_of(NodeId node) const {
  const std::uint32_t place = place_of(node);
  if (place == kNone || !shown_.test(place)) return std::nullopt;
  const std::size_t group = place / kGroup, last = place / BitSet::kWordBits;
  std::size_t row = rows_before_[group];
  for (std::size_t w = group * kGroupWords; w < last; ++w) row += std::size_t(std::popcount(shown_.word(w)));
  return row + std::size_t(std::popcount(shown_.word(last) & BitSet::below(place)));
}

/// Gives all members rows whose ancestors are expanded.
void TreeRows::show_all() {
  shown_ = BitSet(places_.size());
  rows_before_.assign((places_.size() + kGroup - 1) / kGroup + 1, 0);
  if (!places_.empty() && members_.test(0)) {
    shown_.set(0);
    if (expanded_.test(0)) show_below(0);
  }
  recount(0, places_.size());
}

/// Gives rows to what is below an expanded place that has a row. A recount() must follow.
void TreeRows::show_below(std::size_t place) {
  const std::size_t end = places_[place].end;
  for (std::size_t i = members_.next(place + 1); i < end;
       i = members_.next(expanded_.test(i) ? i + 1 : std::size_t(places_[i].end)))
    shown_.set(i);
}

/// Corrects rows_before_ after places from `first` to below `last` got or lost rows.
void TreeRows::recount(std::size_t first, std::size_t last) {
  if (first >= last) return;
  const std::size_t first_group = first / kGroup, last_group = (last - 1) / kGroup;
  const std::uint32_t old_end = rows_before_[last_group + 1];
  for (std::size_t g = first_group; g <= last_group; ++g)
    rows_before_[g + 1] = rows_before_[g] + rows_in_group(shown_, g);
  const std::uint32_t more = rows_before_[last_group + 1] - old_end;  // modulo 2^32 when there are fewer
  for (std::size_t g = last_group + 2; g < rows_before_.size(); ++g) rows_before_[g] += more;
}

// --- expanding -------------------------------------------------------------------------------------------------------

void TreeRows::expand(NodeId node) {
  const std::uint32_t i = place_of(node);
  assert(i != kNone && "expected a node that contains() knows");
  if (!branches_.test(i) || expanded_.test(i)) return;
  expanded_.set(i);
  if (!shown_.test(i)) return;
  show_below(i);
  recount(i + 1, places_[i].end);
}

void TreeRows::collapse(NodeId node) {
  const std::uint32_t i = place_of(node);
  assert(i != kNone && "expected a node that contains() knows");
  if (!expanded_.test(i)) return;
  expanded_.clear(i);
  if (!shown_.test(i)) return;
  shown_.remove(i + 1, places_[i].end);
  recount(i + 1, places_[i].end);
}

void TreeRows::expand_all_below(NodeId node) {
  const std::uint32_t i = place_of(node);
  assert(i != kNone && "expected a node that contains() knows");
  const std::uint32_t end = places_[i].end;
  expanded_.add(branches_, i, end);
  if (!shown_.test(i)) return;
  shown_.add(members_, i + 1, end);
  recount(i + 1, end);
}

std::optional<std::size_t> TreeRows::reveal(NodeId node) {
  const std::uint32_t place = place_of(node);
  if (place == kNone || !members_.test(place)) return std::nullopt;
  std::uint32_t highest = kNone;  // of the collapsed ancestors: it has a row
  for (std::uint32_t i = places_[place].parent; i != kNone; i = places_[i].parent) {
    if (expanded_.test(i)) continue;
    expanded_.set(i);
    highest = i;
  }
  if (highest != kNone) {
    show_below(highest);
    recount(highest + 1, places_[highest].end);
  }
  return row_of(node);
}

// --- the filter ------------------------------------------------------------------------------------------------------

void TreeRows::set_filter(std::span<const NodeId> matches) {
  if (!filtered_) unfiltered_expanded_ = expanded_;
  filtered_ = true;
  matches_ = branches_ = BitSet(places_.size());
  for (const NodeId node : matches) {
    const std::uint32_t place = place_of(node);
    if (place == kNone) continue;
    matches_.set(place);
    for (std::uint32_t i = places_[place].parent; i != kNone && !branches_.test(i); i = places_[i].parent)
      branches_.set(i);
  }
  members_ = matches_;
  members_.add(branches_);
  expanded_ = branches_;
  shown_ = members_;  // all are expanded
  recount(0, places_.size());
}

void TreeRows::clear_filter() {
  if (!filtered_) return;
  let_all_through();
  expanded_ = std::move(unfiltered_expanded_);
  show_all();
}

void TreeRows::let_all_through() {
  filtered_ = false;
  members_ = BitSet(places_.size(), true);
  matches_ = branches_ = BitSet(places_.size());
  for (std::size_t i = 0; i < places_.size(); ++i)
    if (places_[i].end > i + 1) branches_.set(i);
}

// --- labels ----------------------------------------------------------------------------------------------------------

std::string label(const core::Scene& scene, NodeId node) {
  if (const std::string_view name = scene.name(node); !name.empty()) return std::string(name);
  const core::ItemId item = scene.first_item(node);
  if (item == kNoItem) return node == scene.root() ? "Model" : "Group " + std::to_string(node.index);
  std::string kind(core::name_of(scene.kind(item)));
  std::replace(kind.begin(), kind.end(), '_', ' ');
  kind[0] = char(kind[0] - 'a' + 'A');
  return kind + " " + std::to_string(to_index(item));
}

}  // namespace sightline::apps
