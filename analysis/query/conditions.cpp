#include "sightline/analysis/query/conditions.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "sightline/analysis/measure/distances.h"
#include "sightline/analysis/query/internal/leading_number.h"
#include "sightline/analysis/query/values.h"
#include "sightline/core/find_nodes.h"
#include "sightline/core/internal/ascii_case.h"
#include "sightline/core/internal/text_pattern.h"

namespace sightline::query {
namespace {

using core::ItemId;
using core::Scene;

constexpr std::string_view kBetween = " & ", kNearKey = "@near", kOf = " of ";
constexpr std::uint64_t kMostPairs = 100'000'000;

enum class Relation { kLess, kLessOrEqual, kGreater, kGreaterOrEqual, kFits };

struct Condition {
  enum class About { kPart, kNumber, kText, kNear };
  About about = About::kPart;
  bool negated = false;
  std::string key;   // of kNumber and kText
  std::string part;  // of kPart and kNear; the text of kText
  Relation relation = Relation::kFits;
  double number = 0.0;  // of kNumber; metres of kNear
};

bool is_own_key(std::string_view key) {
  const auto keys = own_keys();
  return std::any_of(keys.begin(), keys.end(), [&](const char* own) { return core::same_but_for_case(key, own); });
}

std::optional<double> metres_of(std::string_view text) {
  constexpr std::pair<std::string_view, double> kUnits[] = {{"", 1.0},    {"m", 1.0},     {"mm", 1e-3},
                                                            {"cm", 1e-2}, {"in", 0.0254}, {"ft", 0.3048}};
  const auto read = leading_number(text);
  if (!read) return std::nullopt;
  for (const auto& [unit, metres] : kUnits)
    if (core::same_but_for_case(read->second, unit)) return read->first * metres;
  return std::nullopt;
}

/// A condition in three parts; none where it has no sign.
struct Split {
  std::string_view key, sign, value;
};
std::optional<Split> split(std::string_view text) {
  const std::size_t at = text.find_first_of("=<>!");
  if (at == std::string_view::npos || at == 0) return std::nullopt;
  const std::size_t length = text.size() > at + 1 && text[at + 1] == '=' ? 2 : 1;
  if (text[at] == '!' && length == 1) return std::nullopt;
  return Split{trimmed(text.substr(0, at)), text.substr(at, length), trimmed(text.substr(at + length))};
}

std::optional<Relation> order_of(std::string_view sign) {
  if (sign == "<") return Relation::kLess;
  if (sign == "<=") return Relation::kLessOrEqual;
  if (sign == ">") return Relation::kGreater;
  if (sign == ">=") return Relation::kGreaterOrEqual;
  return std::nullopt;
}

core::Error expected(const std::string& what, std::string_view text) {
  return {"expected " + what + ", found \"" + std::string(text) + "\""};
}

bool is_equality(std::string_view sign) {
  return sign == "==" || sign == "!=";
}

Condition of_text(const Split& parts, std::string_view key) {
  const std::string text(parts.value);
  return {Condition::About::kText, parts.sign == "!=", std::string(key), text, Relation::kFits, 0.0};
}

core::Expected<Condition> parse_near(const Split& parts, std::string_view text) {
  const std::string form = "@near<=LENGTH of PART";
  const std::size_t of = parts.value.find(kOf);
  if (parts.sign != "<=" || of == std::string_view::npos) return tl::unexpected(expected(form, text));
  const auto length = metres_of(trimmed(parts.value.substr(0, of)));
  const std::string_view part = trimmed(parts.value.substr(of + kOf.size()));
  if (!length || *length < 0.0 || part.empty()) return tl::unexpected(expected(form, text));
  return Condition{Condition::About::kNear, false, {}, std::string(part), Relation::kLessOrEqual, *length};
}

core::Expected<Condition> parse_own(const Split& parts, std::string_view text) {
  const std::string key = core::lower_case(parts.key);
  if (key == kNearKey) return parse_near(parts, text);
  if (!is_own_key(key)) return tl::unexpected(expected("@kind, @material, @layer, @file, @size or @near", parts.key));
  if (key == "@size") {
    const auto order = order_of(parts.sign);
    const auto length = metres_of(parts.value);
    if (!order || !length) return tl::unexpected(expected("@size with <, <=, > or >= and a length", text));
    return Condition{Condition::About::kNumber, false, key, {}, *order, *length};
  }
  if (parts.sign != "=" && !is_equality(parts.sign)) return tl::unexpected(expected(key + " with = or !=", text));
  return of_text(parts, key);
}

core::Expected<Condition> parse_condition(std::string_view text) {
  text = trimmed(text);
  if (text.empty()) return tl::unexpected(expected("a condition", text));
  if (text.front() == '!') {
    auto opposite = parse_condition(text.substr(1));
    if (opposite) opposite->negated = !opposite->negated;
    return opposite;
  }
  const auto parts = text.starts_with("re:") ? std::nullopt : split(text);
  if (text.front() == '@') {
    if (!parts) return tl::unexpected(expected("a key, a sign and a value", text));
    return parse_own(*parts, text);
  }
  if (parts) {
    const auto order = order_of(parts->sign);
    const auto number = order ? leading_number(parts->value) : std::nullopt;
    if (number && number->second.empty())
      return Condition{Condition::About::kNumber, false, std::string(parts->key), {}, *order, number->first};
    if (is_equality(parts->sign)) return of_text(*parts, parts->key);
    if (parts->sign == "=")
      return Condition{Condition::About::kPart, false, {}, std::string(parts->key) + "=" + std::string(parts->value)};
  }
  return Condition{Condition::About::kPart, false, {}, std::string(text)};
}

core::Expected<std::vector<Condition>> parse(std::string_view text) {
  std::vector<Condition> conditions;
  for (;;) {
    const std::size_t end = text.find(kBetween);
    auto condition = parse_condition(text.substr(0, end));
    if (!condition) return tl::unexpected(condition.error());
    conditions.push_back(std::move(*condition));
    if (end == std::string_view::npos) return conditions;
    text.remove_prefix(end + kBetween.size());
  }
}

bool holds(Relation relation, double value, double number) {
  switch (relation) {
    case Relation::kLess:
      return value < number;
    case Relation::kLessOrEqual:
      return value <= number;
    case Relation::kGreater:
      return value > number;
    case Relation::kGreaterOrEqual:
      return value >= number;
    case Relation::kFits:
      break;
  }
  return false;
}

using Marks = std::vector<bool>;  // by item

/// The items below the nodes that a text names.
core::Expected<Marks> below(const Scene& scene, const std::string& part) {
  const core::NodeCondition named{"", part};
  const auto found = core::find_nodes(scene, scene.root(), {&named, 1});
  if (!found) return core::fail("\"" + part + "\": " + found.error().message);
  if (found->nodes.empty()) return core::fail("no part fits \"" + part + "\"");
  Marks marks(scene.item_slots());
  for (const core::NodeId top : found->nodes)
    scene.for_each_node(top, [&](core::NodeId node, const auto&...) {
      for (ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item))
        marks[to_index(item)] = true;
    });
  return marks;
}

/// The items whose value fulfils `test`.
template <class Test>
core::Expected<Marks> of_values(const Scene& scene, const std::string& key, const Test& test) {
  const auto values = values_of(scene, key);
  if (!values) return tl::unexpected(values.error());
  Marks fulfils(values->all.size()), marks(scene.item_slots());
  for (std::size_t i = 0; i < fulfils.size(); ++i) fulfils[i] = test(values->all[i].text);
  for (std::size_t i = 0; i < marks.size(); ++i)
    marks[i] = values->of_item[i] != core::kNone && fulfils[values->of_item[i]];
  return marks;
}

struct Placed {
  ItemId item;
  core::AabbD box;
  std::optional<measure::Item> prepared;  // once a distance was asked for
};

std::vector<Placed> placed(const Scene& scene, const Marks& marks) {
  std::vector<ItemId> items;
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (marks[i]) items.push_back(ItemId(i));
  std::vector<Placed> all;
  scene.for_each_state(items, [&](ItemId item, const Scene::ItemState& state) {
    const core::AabbD box = scene.bounds_under(item, state.world_from_item);
    if (!box.empty()) all.push_back({item, box, {}});
  });
  return all;
}

bool boxes_within(const core::AabbD& a, const core::AabbD& b, double distance) {
  for (int axis = 0; axis < 3; ++axis)
    if (a.min[axis] > b.max[axis] + distance || b.min[axis] > a.max[axis] + distance) return false;
  return true;
}

core::Expected<bool> are_within(const Scene& scene, Placed& a, Placed& b, double distance) {
  for (Placed* one : {&a, &b}) {
    if (one->prepared) continue;
    auto made = measure::Item::create(scene, one->item);
    if (!made) return tl::unexpected(made.error());
    one->prepared = std::move(*made);
  }
  const measure::Distance found = measure::distance(*a.prepared, *b.prepared);
  return found.distance - found.error <= distance;
}

/// The items of `among` for which the condition holds, without regard to its opposite.
core::Expected<Marks> marks_near(const Scene& scene, const Condition& condition, const Marks& among) {
  const auto to = below(scene, condition.part);
  if (!to) return tl::unexpected(to.error());
  std::vector<Placed> there = placed(scene, *to);
  core::AabbD all;
  for (const Placed& one : there) all.grow(one.box);
  std::uint64_t pairs = 0;
  Marks near(among.size());
  for (Placed& one : placed(scene, among)) {
    if ((*to)[to_index(one.item)] || !boxes_within(one.box, all, condition.number)) continue;
    if ((pairs += there.size()) > kMostPairs)
      return core::fail("@near: more than 100 million pairs to look at; add conditions that leave fewer items");
    for (std::size_t i = 0; i < there.size() && !near[to_index(one.item)]; ++i) {
      if (!boxes_within(one.box, there[i].box, condition.number)) continue;
      const auto within = are_within(scene, one, there[i], condition.number);
      if (!within) return tl::unexpected(within.error());
      near[to_index(one.item)] = *within;
    }
  }
  return near;
}

core::Expected<Marks> marks_of(const Scene& scene, const Condition& condition, const Marks& among) {
  switch (condition.about) {
    case Condition::About::kNear:
      return marks_near(scene, condition, among);
    case Condition::About::kNumber:
      return of_values(scene, condition.key, [&](const std::string& text) {
        const auto number = number_of(text);
        return number && holds(condition.relation, *number, condition.number);
      });
    case Condition::About::kText: {
      const auto pattern = core::TextPattern::wildcards(condition.part);
      return of_values(scene, condition.key, [&](const std::string& text) { return pattern.fits(text); });
    }
    case Condition::About::kPart:
      break;
  }
  return below(scene, condition.part);
}

}  // namespace

bool is_query(std::string_view text) {
  const auto conditions = parse(text);
  return !conditions || conditions->size() > 1 || conditions->front().negated ||
         conditions->front().about != Condition::About::kPart;
}

core::Expected<void> check_query(std::string_view text) {
  const auto conditions = parse(text);
  if (!conditions) return tl::unexpected(conditions.error());
  const Scene none;
  for (const Condition& condition : *conditions) {
    if (condition.part.empty() || condition.about == Condition::About::kText) continue;
    const core::NodeCondition named{"", condition.part};
    if (const auto found = core::find_nodes(none, none.root(), {&named, 1}); !found)
      return core::fail("\"" + condition.part + "\": " + found.error().message);
  }
  return {};
}

core::Expected<std::vector<ItemId>> find_items(const Scene& scene, std::string_view text) {
  auto conditions = parse(text);
  if (!conditions) return tl::unexpected(conditions.error());
  // Distances take longest.
  std::stable_partition(conditions->begin(), conditions->end(),
                        [](const Condition& condition) { return condition.about != Condition::About::kNear; });
  Marks marks(scene.item_slots());
  for (std::size_t i = 0; i < marks.size(); ++i) marks[i] = scene.contains_item(ItemId(i));
  for (const Condition& condition : *conditions) {
    const auto found = marks_of(scene, condition, marks);
    if (!found) return tl::unexpected(found.error());
    for (std::size_t i = 0; i < marks.size(); ++i) marks[i] = marks[i] && (*found)[i] != condition.negated;
  }
  std::vector<ItemId> items;
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (marks[i]) items.push_back(ItemId(i));
  return items;
}

}  // namespace sightline::query
