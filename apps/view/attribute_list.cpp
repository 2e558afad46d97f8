#include "sightline/apps/view/attribute_list.h"

#include <algorithm>
#include <utility>

#include "sightline/analysis/query/colouring.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/item_facts.h"
#include "sightline/apps/common/markup.h"

namespace sightline::apps {
namespace {

using Row = std::vector<std::string>;

std::string text_of(const Row& row, char separator) {
  std::string text;
  for (std::size_t i = 0; i < row.size(); ++i)
    text += (i > 0 ? std::string(1, separator) : "") + csv_field(row[i], separator);
  return text + "\n";
}

/// Attributes of the item's node and of those above: of several with a key the nearest.
std::vector<Fact> all_attributes(const core::Scene& scene, core::ItemId item) {
  std::vector<Fact> all;
  for (core::NodeId node = scene.node_of(item); node.valid(); node = scene.parent(node))
    for (Fact& fact : attribute_facts(scene, node))
      if (std::none_of(all.begin(), all.end(), [&](const Fact& known) { return known.name == fact.name; }))
        all.push_back(std::move(fact));
  return all;
}

}  // namespace

void AttributeList::follow_scene() {
  keys_.reset();
  values_.reset();
}

const std::vector<query::Key>& AttributeList::keys() {
  if (keys_) return *keys_;
  keys_ = query::attribute_keys(*scene_);
  for (const char* key : query::own_keys()) keys_->push_back({key, std::uint32_t(scene_->item_count()), 0});
  return *keys_;
}

void AttributeList::choose(const std::string& key) {
  chosen_ = key;
  values_.reset();
}

const query::Values& AttributeList::values() {
  if (values_) return *values_;
  values_ = query::values_of(*scene_, chosen_).value_or(query::Values());
  has_numbers_ = query::are_numbers(*values_);
  return *values_;
}

bool AttributeList::has_numbers() {
  return values(), has_numbers_;
}

std::string condition_of(const std::string& key, const std::string& value) {
  if (key == "@size") return key + ">=" + value + " & " + key + "<=" + value;
  return key + "==" + value;
}

core::Expected<std::string> condition_of_range(const std::string& key, const std::string& from, const std::string& to) {
  std::string condition;
  for (const auto& [sign, bound] : {std::pair(">=", &from), std::pair("<=", &to)}) {
    if (bound->empty()) continue;
    if (const auto number = parse_finite(*bound); !number) return tl::unexpected(number.error());
    condition += (condition.empty() ? "" : " & ") + key + sign + *bound;
  }
  if (condition.empty()) return core::fail("expected a number to begin or to end with");
  return condition;
}

std::string properties_table(const core::Scene& scene, std::span<const core::ItemId> items, char separator) {
  if (items.size() == 1) {
    std::string text = text_of({"path", scene.path(scene.node_of(items[0]))}, separator);
    for (const auto& facts : {item_facts(scene, items[0]), all_attributes(scene, items[0])})
      for (const Fact& fact : facts) text += text_of({fact.name, fact.value}, separator);
    return text;
  }
  Row head{"path", "kind"};
  std::vector<Row> rows;
  for (const core::ItemId item : items) {
    Row row{scene.path(scene.node_of(item)), std::string(core::name_of(scene.kind(item)))};
    for (Fact& fact : all_attributes(scene, item)) {
      auto column = std::find(head.begin() + 2, head.end(), fact.name);
      if (column == head.end()) column = head.insert(head.end(), fact.name);
      const auto place = std::size_t(column - head.begin());
      row.resize(std::max(row.size(), place + 1));
      row[place] = std::move(fact.value);
    }
    rows.push_back(std::move(row));
  }
  std::string text = text_of(head, separator);
  for (Row& row : rows) row.resize(head.size()), text += text_of(row, separator);
  return text;
}

}  // namespace sightline::apps
