// The scene's tree as the viewer shows it: rows, and the search typed above them. No window.
#pragma once

#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "sightline/apps/common/named_parts.h"
#include "sightline/apps/view/name_search.h"
#include "sightline/apps/view/tree_rows.h"

namespace sightline::apps {

class ModelTree {
 public:
  /// The scene is borrowed. Names are indexed in the background.
  explicit ModelTree(const core::Scene& scene);

  /// Nothing reads the scene afterwards, until follow_scene() takes notice of what was edited: rows, and what the last
  /// find() has found. No edit may come but between the two.
  void release_scene();
  void follow_scene();

  TreeRows& rows() { return rows_; }

  /// Shows the nodes that hold the text, to choose from, and their ancestors; an empty text: all nodes. Where none
  /// holds it, those that it names, or of the items for which its conditions hold. Waits for the index.
  void find(const NameQuery& query);
  /// Shows what the text names (named_items(); "KEY:TEXT" is also understood), or the nodes that a regular expression
  /// matches, and says how many there are. Fails where there is nothing, and then shows what find() does.
  core::Expected<std::string> find_named(const NameQuery& query);
  /// Whether find() shows nodes that hold the text: items() are then those of all of them, also beyond the rows.
  bool find_letters();
  /// Items that a text names, whatever is shown.
  core::Expected<NamedItems> items_named(const std::string& text);
  /// The items of what is found, in rising order.
  std::vector<core::ItemId> items() const;
  const NameQuery& query() const { return query_; }
  std::size_t match_count() const { return matches_.count; }
  bool named() const { return named_; }                ///< whether those are named, and not only hold the text
  const std::string& error() const { return error_; }  ///< of an expression or a condition; empty without one

  /// Expands what is above a node; the list should scroll there.
  void reveal(core::NodeId node);
  /// The row to scroll to, once.
  std::optional<std::size_t> take_revealed();

 private:
  void show_named(const core::FoundNodes& found);
  core::Expected<void> show_items_of(const std::string& conditions);
  core::Expected<core::FoundNodes> by_rule(const std::string& text) const;

  const core::Scene* scene_;
  NameIndex index_;
  TreeRows rows_;
  NameQuery query_;
  NameMatches matches_;
  std::optional<std::vector<core::ItemId>> items_;  // for which conditions hold
  bool named_ = false;
  std::string error_;
  std::optional<std::size_t> revealed_;
  std::jthread indexing_;  // last: it writes index_
};

}  // namespace sightline::apps
