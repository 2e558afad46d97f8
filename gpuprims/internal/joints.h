// Joints: coplanar end faces of neighbouring solids, such as the end of a pipe and that of its elbow. An end face that
// its neighbour covers is invisible from outside, and from inside, too, since rays are cast at solids. It is not drawn.
//
// End faces are the flat ends of cylinders, snouts (slanted ones, too) and slices of circular tori, and the bases of
// dishes. Each is an ellipse under any affine placement. One face covers another when their outward normals are
// opposite, their centres coincide, and the covered face nowhere reaches beyond the other. For example, where a pipe
// meets a wider flange, only the pipe's end is covered; of two equal ends both are. Two spherical dishes have no joint:
// shaders do not extend their bases. Shaders extend all other covered ends a little into the neighbour (search.glsl),
// so that no ray passes between the two. Both items must be visible, in the same layers, and opaque.
//
// A culler that keeps one of two neighbours and drops the other would let the viewer look into an open end.
// Conservative cullers drop only what is outside the view, so this does not happen.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <vector>

#include "sightline/core/affine.h"
#include "sightline/core/conventions.h"
#include "sightline/core/large_array.h"
#include "sightline/core/primitive.h"
#include "sightline/core/snapshot.h"

namespace sightline::gpuprims {

// Tolerances, in units of the covered face's smaller half-axis. They hold between the placements that are drawn, those
// of the snapshot. Real files store coordinates in float: their neighbours differ by up to 1e-3 radii.
/// Largest distance between the two planes, tilt included. Equal to kInternalCapOverlap in search.glsl, by which
/// shaders extend each covered end.
inline constexpr double kJointGap = 2e-4;
/// How far the covered face may reach beyond the other, sideways.
inline constexpr double kJointExcess = 1e-4;

/// Ends of an item, as bits. "Bottom" is z = -height/2, the start of a sweep, the base of a dish.
enum Ends : std::uint8_t { kNoEnd = 0, kBottomEnd = 1, kTopEnd = 2 };

/// A flat end in the world: the ellipse centre + u cos a + v sin a. u x v points out of the solid.
struct EndFace {
  core::dvec3 centre{0.0}, u{0.0}, v{0.0};
};

/// The face at one end. None where the primitive has no such end, or where the end's contour is not a whole ellipse:
/// closed tori, solids without volume, tips, slanted ends that cut each other or are steeper than their cone.
std::optional<EndFace> end_face(const core::Primitive& primitive, const core::Affine& world_from_item, Ends end);

/// True when `face` is covered by `other`, as said above. Constant time.
bool covers(const EndFace& other, const EndFace& face);

/// Which ends are covered, as a scene cache stores it with a snapshot.
struct StoredJoints {
  core::LargeArray<std::uint64_t> bits;    ///< two per item
  core::LargeArray<std::uint64_t> covers;  ///< rising: covering item << 32 | covered item << 1 | its end is the top
  core::LargeArray<std::uint32_t> first;   ///< per 32 items: index of the first entry in `covers`
  core::LargeArray<std::uint8_t> opaque;   ///< by material, as it was when joints were looked for
};
/// The joints that a snapshot came with; null where it had none or was changed since.
const StoredJoints* stored_joints(const core::Snapshot& snapshot);

/// The covered ends of a snapshot's items.
class Joints {
 public:
  Joints() = default;  ///< none
  /// Time linear in the number of ends. Where more ends meet in one place than in any sound model, some joints may be
  /// overlooked; their ends are then drawn. Faces more than fifty times the usual size are held to the tolerance of
  /// fifty times the usual size.
  /// Finds the joints of a snapshot, unless a scene cache brought them.
  explicit Joints(const core::Snapshot& snapshot);
  /// Joints of the slots of a core::Page, two bits each. They know no items and cannot follow edits.
  static Joints of_slots(std::vector<std::uint64_t> bits);
  /// For a scene cache, as made from `snapshot`.
  StoredJoints stored(const core::Snapshot& snapshot) const;

  /// Covered ends of an item.
  Ends covered(core::ItemId item) const;
  /// The covered ends of a slot's item, for any Joints.
  Ends covered(const core::Snapshot& snapshot, core::Slot slot) const {
    return covered_at(of_slots_ ? slot : to_index(snapshot.item(slot)));
  }
  /// Covered ends of all items.
  std::size_t count() const { return count_; }

  // Both functions below follow an edit of the snapshot, after Snapshot::apply. They append the slots of neighbours
  // whose ends no longer are covered to `touched`, which apply() returned: those of its former_size slots, each once.
  // They do not search for new joints.
  /// Uncovers the ends of items that were changed or removed, and the ends that these cover.
  void dissolve(const core::Snapshot& snapshot, std::initializer_list<std::span<const core::ItemId>> edited,
                std::size_t former_size, std::vector<core::Slot>& touched);
  /// Dissolves the joints of all items that are no longer opaque, because their material was edited. Time linear in the
  /// number of materials, and in that of slots when one has turned from opaque to transparent.
  void dissolve_transparent(const core::Snapshot& snapshot, std::size_t former_size, std::vector<core::Slot>& touched);

  /// Nothing while no end is covered, else two bits per item and eight bytes per covered end.
  std::size_t memory_bytes() const;

 private:
  friend class JointSearch;
  bool set(core::ItemId item, Ends end, bool covered);
  Ends covered_at(std::uint32_t index) const;
  void prefetch(core::ItemId item) const;
  void dissolve(core::ItemId item, std::vector<core::ItemId>& uncovered);

  bool of_slots_ = false;              // bits_ are by slot; only without covers_
  std::vector<std::uint64_t> bits_;    // two per item
  std::vector<std::uint64_t> covers_;  // sorted: covering item << 32 | covered item << 1 | its end is the top
  std::vector<std::uint32_t> first_;   // per 32 items: index of the first entry in covers_
  std::vector<bool> opaque_;           // by material, as last looked at; empty while no end is covered
  std::size_t count_ = 0;
};

}  // namespace sightline::gpuprims
