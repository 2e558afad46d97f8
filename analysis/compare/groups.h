// Groups of equal changes: "/plant/line-3 moved by 1 m" instead of a line for each of its 5,000 items.
//
// An item may have changed in several ways, and is then in several groups: one that has moved with its line and has
// got another colour is in the group of the line's move and in a group of the colour. Only the move of an item whose
// shape differs, too, is left to the group of the shape.
//
// A group stands at the topmost node below which every item has changed in this way, or, where that would make many
// groups of one change, at the lowest node that holds all of them if they are at least nine tenths of what could have
// changed so: of all items below the node for added and removed items, else of those that both revisions have. What
// remains of a node's own items and those of its leaves, the children without children, is a group of the node.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/analysis/compare/compare.h"
#include "sightline/core/aabb.h"

namespace sightline::compare {

/// In which way the items of a group have changed alike.
enum class Way : std::uint8_t {
  kAdded,
  kRemoved,
  kMoved,           ///< by the same displacement, and the same turn
  kShape,           ///< from the same kind to the same other kind, or without change of the kind
  kMaterial,        ///< to the same material
  kAttributes,      ///< attributes of the same names
  kNodeAttributes,  ///< the same, of nodes without items: Comparison::nodes
  kRenamed,         ///< renamed, or below another node
};

/// "added", "removed", "moved", "changed" or "renamed"
SIGHTLINE_API std::string_view name_of(Way way);

struct Group {
  Way way = Way::kAdded;
  core::NodeId node;                 ///< of the later revision; of the earlier one where items were removed
  std::uint32_t begin = 0, end = 0;  ///< of its members in Groups::members, at least one
  std::uint32_t of = 0;     ///< how many items (or nodes) there are that could have changed so: more than its members
                            ///< where not all have
  core::AabbD box;          ///< of its items in the world, where they are now, or were; empty for kNodeAttributes
  core::dvec3 offset{0.0};  ///< kMoved: metres, by which the centre of the items moved
  double turn = 0.0;        ///< kMoved: radians, 0 to pi
  core::dvec3 axis{0.0};    ///< kMoved: of the turn, of length 1; 0 where nothing turned

  std::size_t size() const { return end - begin; }
};

struct Groups {
  std::vector<Group> all;              ///< those with more members first; of equally many, those with the larger box
  std::vector<std::uint32_t> members;  ///< indices of Comparison::items, or of its nodes, group by group in tree order
};

/// Groups what a comparison of these revisions has found with this tolerance. Displacements within twice the tolerance
/// count as the same. O(n log n) in nodes and items, of which unchanged ones cost little. Reads the scenes only.
SIGHTLINE_API Groups grouped(const Revision& before, const Revision& after, const Comparison& found, double tolerance);

}  // namespace sightline::compare
