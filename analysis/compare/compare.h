// compare: what changed between two revisions of a model. It needs core alone.
//
// Each item of either revision is unchanged, added, removed, moved or changed. Files have no ids that last from one
// revision to the next, so items are matched by what they are called and what they look like, each at most once:
//   1. the same path of node names, the same shape and the same place;
//   2. the same path of node names with the order among equal names, and the order among the items of the node;
//   3. the same shape at the same place: renamed, or below another node;
//   4. the same shape below nodes whose parents have the same path: moved under another name.
// Within a step the first free item in tree order wins. What is left is removed or added. Unnamed nodes count as nodes
// with equal names.
//
// Promises. An item has not moved when the corners of its box, or all vertices of a mesh, lie within the tolerance of
// where they were. Else it has moved, unless it is a solid turned onto itself; whether it is, is approximate. Paths are
// compared by hashes of 64 bits, so two different paths of n count as equal with probability n^2 / 2^65. In steps 1, 3
// and 4 an item gives up after 64 others of the same centre and size that differ in shape, so time stays O(n log n);
// more of them at one point may be called removed and added. How this is found, and what it costs:
// docs/guide/comparing.md.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"

namespace sightline::compare {

struct Options {
  /// Metres, finite and >= 0: how far apart points of an item may lie that count as the same. To this adds what the
  /// scene's own numbers cannot hold: 4e-7 of the item's size and 1.5e-14 of its distance from the origin.
  double tolerance = 1e-4;
  /// Called now and then by the comparing thread with the share that is done, rising from 0 to 1. Returning false
  /// cancels the comparison, which then fails with kCancelled as its message.
  std::function<bool(double)> progress = {};
};

inline constexpr std::string_view kCancelled = "cancelled";

/// The part of a scene that is compared: the subtree of `top`, with all layers, hidden items too. The name of `top` is
/// no part of paths, so that files of different names can be compared. Placements are those in the scene's world.
struct Revision {
  const core::Scene* scene = nullptr;  ///< must be as commit() accepts it
  core::NodeId top;
};

enum class State : std::uint8_t {
  kUnchanged,
  kAdded,
  kRemoved,
  kMoved,    ///< the same shape at another place
  kChanged,  ///< shape, material or attributes differ
};
inline constexpr std::size_t kStateCount = 5;

/// "unchanged", "added", …
SIGHTLINE_API std::string_view name_of(State state);

/// What differs between the items of a pair: bits.
enum Difference : std::uint8_t {
  kShape = 1,       ///< kind, size, or the vertices and triangles of a mesh (their order counts)
  kPlace = 2,       ///< where the item is; of items that differ in shape, where their centres are
  kMaterial = 4,    ///< name, colour or transparency of the material that the item has or inherits
  kAttributes = 8,  ///< of the item's own node; their order does not matter
  kPath = 16,       ///< names of the node and those above it. Leaves the state as it is: renamed alone is unchanged
};

struct Change {
  core::ItemId before = core::kNoItem;  ///< kNoItem when added
  core::ItemId after = core::kNoItem;   ///< kNoItem when removed
  State state = State::kUnchanged;
  std::uint8_t differences = 0;  ///< bits of Difference; 0 when added or removed
  double turn = 0.0;             ///< radians, 0 … pi, by which the placement turned; 0 where the shape differs
  core::dvec3 offset{0.0};       ///< metres in the world, by which the centre moved; 0 without kPlace
};

/// Nodes that hold no items of their own and have different attributes. Their path occurs once in both revisions.
struct NodeChange {
  core::NodeId before, after;
};

struct Comparison {
  std::vector<Change> items;      ///< every item once: those of the later revision in tree order, then the removed ones
  std::vector<NodeChange> nodes;  ///< in tree order
  std::array<std::size_t, kStateCount> counts{};  ///< of items, by State
  std::size_t renamed = 0;                        ///< items with kPath, whatever their state
  /// Attributes were compared: not where the nodes of items have some in one revision and none at all in the other,
  /// which was then written or read without them.
  bool with_attributes = true;

  std::size_t count(State state) const { return counts[std::size_t(state)]; }
  /// No item and no node differs; names may.
  bool same() const { return count(State::kUnchanged) == items.size() && nodes.empty(); }
};

/// Compares two revisions, which may be of one scene. Fails on a tolerance out of its range, and when cancelled. O(n
/// log n) in nodes and items, linear in vertices; needs some 250 bytes an item of either revision meanwhile. Reads the
/// scenes only: any number of threads may.
SIGHTLINE_API core::Expected<Comparison> revisions(const Revision& before, const Revision& after,
                                                   const Options& options = {});

}  // namespace sightline::compare
