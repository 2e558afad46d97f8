// Items by names that stay the same when a model is read again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "sightline/core/scene.h"

namespace sightline::apps {

/// A subtree, or one item of a node.
struct PartName {
  std::string node;                   ///< core::Scene::path(); empty: the whole model
  std::uint32_t nth = 0;              ///< of the nodes with this path, in tree order
  std::optional<std::uint32_t> item;  ///< of the node's own items, in their order; none: all below the node
  std::string guid;                   ///< of the node's attribute IfcGuid; finds the node where its path does not

  friend bool operator==(const PartName&, const PartName&) = default;
};

/// A part as text: its node's path, followed where needed by "?nth=N" (the Nth node with this path, from 1), "?item=N"
/// (from 1) or "?nth=N&item=M". Without its GUID.
std::string to_text(const PartName& part);
PartName part_of(std::string_view text);

/// Items that are named, or all others.
struct PartSet {
  bool all_but = false;
  std::vector<PartName> parts;

  bool empty() const { return !all_but && parts.empty(); }
  friend bool operator==(const PartSet&, const PartSet&) = default;
};

/// The names of a scene, which must not be edited meanwhile. Takes a step per node to make.
class ItemNames {
 public:
  explicit ItemNames(const core::Scene& scene);

  /// Few names for these items: of whole subtrees where all their items are among them, and, if `others` says so, of
  /// all others where those are fewer.
  PartSet name(std::span<const core::ItemId> items, bool others) const;

  struct Found {
    std::vector<core::ItemId> items;  ///< in rising order
    std::size_t missing = 0;          ///< names that the scene does not have
  };
  Found find(const PartSet& set) const;

 private:
  struct Place {
    core::NodeId node;
    std::uint64_t path;                               // its hash
    std::uint32_t nth;                                // of the places with this path
    std::uint32_t position;                           // among its siblings
    std::uint32_t parent, end;                        // places; the subtree ends before `end`
    std::uint32_t first_item, own_end, end_item = 0;  // in items_: its own, those of the subtree
  };
  std::vector<PartName> parts(const std::vector<bool>& marked) const;
  std::string label(const Place& place) const;
  PartName name_of(const Place& place) const;
  const Place* place_of(const PartName& part) const;

  const core::Scene* scene_;
  std::vector<Place> places_;        // in tree order
  std::vector<core::ItemId> items_;  // in the order of their nodes
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> by_path_;
  std::unordered_map<std::string, std::uint32_t> by_guid_;
};

}  // namespace sightline::apps
