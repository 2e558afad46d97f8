// The rows of an expandable tree of a scene's nodes, for a list that shows some 50 rows of a million nodes.
//
// Rows are the nodes whose ancestors are all expanded, in tree order. The root is the first row. Items are no rows: a
// node's row says how many items it holds. Nodes are numbered in tree order, so a subtree is a range of numbers, and
// the rows are a set of bits. For n nodes:
// - row() and row_of() take a binary search over n / 512 sums;
// - expand() takes a step per row that appears, collapse() and expand_all_below() one per 64 nodes of the subtree, and
//   each of them one addition per 512 nodes after it;
// - reset() and a filter take a step per node.
//
// The tree is a copy of the scene's at the last reset(). It becomes stale when nodes are added, removed or reparented,
// or items added or removed; names are not kept. A stale tree is safe to use, but its rows may name removed nodes
// (Scene::contains).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sightline/apps/view/bit_set.h"
#include "sightline/core/scene.h"

namespace sightline::apps {

struct TreeRow {
  core::NodeId node;
  std::uint32_t depth;  ///< 0 for the root
  std::uint32_t items;  ///< that hang on the node itself
  bool has_children;    ///< with a filter: that it shows
  bool expanded;        ///< false without children
  bool match;           ///< the filter was set with this node
};

class TreeRows {
 public:
  /// Copies the tree. Nodes that were there before stay expanded or collapsed; new ones are collapsed. The root is
  /// expanded when it gets its first children. Clears the filter.
  void reset(const core::Scene& scene);
  /// Whether the scene has another number of nodes or items than at reset(). Does not notice a node that was
  /// reparented, or replaced by another: whoever does that calls reset().
  bool stale(const core::Scene& scene) const;

  /// Whether the node was in the scene at reset().
  bool contains(core::NodeId node) const;
  std::size_t row_count() const { return rows_before_.back(); }
  /// `index` must be below row_count().
  TreeRow row(std::size_t index) const;
  /// None if an ancestor is collapsed, the filter leaves the node out, or contains() is false.
  std::optional<std::size_t> row_of(core::NodeId node) const;

  // For these contains() must be true. Nodes without a row may be expanded, too; those without children stay as they
  // are. Collapsing a node leaves those below it as they are.
  void expand(core::NodeId node);
  void collapse(core::NodeId node);
  /// Expands the node and all nodes below it.
  void expand_all_below(core::NodeId node);

  /// Expands all nodes above this one. Returns its row; none if the filter leaves it out or contains() is false.
  std::optional<std::size_t> reveal(core::NodeId node);

  /// Shows only these nodes, marked, and their ancestors, expanded. Ignores nodes that contains() does not know. What
  /// is expanded now comes back with clear_filter().
  void set_filter(std::span<const core::NodeId> matches);
  void clear_filter();
  bool filtered() const { return filtered_; }

  /// The places of a node and all below it in tree order, whether they have rows or not: the first and the one behind
  /// the last, both below or equal to place_count(). None if contains() is false.
  std::optional<std::pair<std::uint32_t, std::uint32_t>> range(core::NodeId node) const;
  std::size_t place_count() const { return places_.size(); }
  std::uint64_t resets() const { return resets_; }  ///< calls of reset() so far: places are others after each

  std::size_t memory_bytes() const;

 private:
  struct Place {
    core::NodeId node;
    std::uint32_t parent, end;  // places; the subtree ends before `end`
    std::uint32_t depth, items;
  };

  std::uint32_t place_of(core::NodeId node) const;
  void copy_tree(const core::Scene& scene);
  void let_all_through();
  void show_all();
  void show_below(std::size_t place);
  void recount(std::size_t first, std::size_t last);

  std::vector<Place> places_;                  // in tree order
  std::vector<std::uint32_t> place_of_;        // by NodeId::index
  std::size_t items_ = 0;                      // of the scene at reset()
  BitSet members_;                             // places that the filter lets through
  BitSet branches_;                            // members that have a child among the members
  BitSet expanded_;                            // some of branches_
  BitSet matches_;                             // that the filter was set with
  BitSet unfiltered_expanded_;                 // expanded_ while there was no filter
  BitSet shown_;                               // places with a row
  std::vector<std::uint32_t> rows_before_{0};  // each group of words of shown_; the last one is the sum
  bool filtered_ = false;
  std::uint64_t resets_ = 0;
};

/// What a tree calls a node: its name; else the kind and number of its first item, "Cylinder 12"; else "Group 12" with
/// the node's number. The root without a name is "Model".
std::string label(const core::Scene& scene, core::NodeId node);

}  // namespace sightline::apps
