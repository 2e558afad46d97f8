// What a model says of its items, to look through: keys, and the values of one of them. No window.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sightline/analysis/query/values.h"

namespace sightline::apps {

class AttributeList {
 public:
  /// The scene is borrowed. Nothing is read of it before keys() or values() are asked for.
  explicit AttributeList(const core::Scene& scene) : scene_(&scene) {}
  /// Forgets what was read.
  void follow_scene();

  /// Attributes, those of most items first, and then the keys with "@".
  const std::vector<query::Key>& keys();
  const std::string& chosen() const { return chosen_; }  ///< empty: none
  void choose(const std::string& key);
  /// These are of the chosen key; empty where nothing has a value.
  const query::Values& values();
  bool has_numbers();  ///< query::are_numbers() the values

 private:
  const core::Scene* scene_;
  std::string chosen_;
  std::optional<std::vector<query::Key>> keys_;
  std::optional<query::Values> values_;
  bool has_numbers_ = false;
};

/// A condition (analysis/query/conditions.h) for items with this value.
std::string condition_of(const std::string& key, const std::string& value);
/// So for numbers between two, either of which may be empty. Fails where one is no number, or both are empty.
core::Expected<std::string> condition_of_range(const std::string& key, const std::string& from, const std::string& to);

/// Names and values of an item: what it is, and the attributes of its node and of those above, for a table with two
/// columns. Of several items: a row for each, with its path, its kind and their attributes. Columns are separated by
/// `separator`, rows end in line feeds, and cells are quoted as in CSV (RFC 4180) where they need it.
std::string properties_table(const core::Scene& scene, std::span<const core::ItemId> items, char separator);

}  // namespace sightline::apps
