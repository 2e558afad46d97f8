// Joints: where two solids lie on each other face to face, as a pipe's end on its elbow's. What is covered so need not
// be drawn, and cannot be seen: neither from outside nor, since rays are cast at solids, from within.
//
// Faces are the flat ends of cylinders, snouts (slanted ones, too), slices of circular tori, and the bases of dishes,
// each an ellipse under whatever placement. A face is covered by another when both have opposite outward normals, their
// centres coincide, and it nowhere reaches beyond the other; so of a pipe on a wider flange only the pipe's end is
// covered, of equal ones both are. Two spherical dishes have no joint: their bases do not reach. Shaders let covered
// ends reach a little into the neighbour (search.glsl), so that no ray passes between. Both items must be visible, in
// the same layers, and opaque.
//
// Whoever draws one of two neighbours without the other, as no culler does that keeps its promise, looks into an open
// end there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "sightline/core/affine.h"
#include "sightline/core/conventions.h"
#include "sightline/core/primitive.h"

namespace sightline::core {

class Snapshot;

// What is compared is what is drawn, the snapshot's own placements; real files, with coordinates in float, are off by
// up to 1e-3 radii. Tolerances are in units of the covered face's smaller half-axis.
/// Between the planes, tilt included: as far as shaders let each covered end reach (kHiddenReach in search.glsl).
inline constexpr double kJointGap = 2e-4;
/// How far the covered face may reach beyond the other, sideways.
inline constexpr double kJointExcess = 1e-4;

/// Ends of an item, as bits. "Bottom" is z = -height/2, the start of a sweep, the base of a dish.
enum Ends : std::uint8_t { kNoEnd = 0, kBottomEnd = 1, kTopEnd = 2 };

/// A flat end in the world: the ellipse centre + u cos a + v sin a. u x v points out of the solid.
struct EndFace {
  dvec3 centre{0.0}, u{0.0}, v{0.0};
};

/// The face at one end. None where the primitive has no such end, or none whose contour is a whole ellipse: closed
/// tori, solids without volume, tips, slanted ends that cut each other or are steeper than their cone.
std::optional<EndFace> end_face(const Primitive& primitive, const Affine& world_from_item, Ends end);

/// True when `face` is covered by `other`, as said above. Constant time.
bool covers(const EndFace& other, const EndFace& face);

/// The covered ends of a snapshot's items.
class Joints {
 public:
  Joints() = default;  ///< none
  /// Time linear in the number of ends. Of many ends in one place, more than there are in any sound model, some may be
  /// overlooked, which only means that they are drawn. Faces more than fifty times the usual size are held to the
  /// tolerance of that size.
  explicit Joints(const Snapshot& snapshot);

  /// Covered ends of an item.
  Ends covered(ItemId item) const;
  /// Covered ends of all items.
  std::size_t count() const { return count_; }

  /// Shows again the ends of an item that has been changed or removed, and those that it covers, whose items are
  /// appended to `uncovered`. Joints are not looked for again.
  void dissolve(ItemId item, std::vector<ItemId>& uncovered);

  /// Nothing while no end is covered, else two bits per item and eight bytes per covered end.
  std::size_t memory_bytes() const;

 private:
  friend class JointSearch;
  bool set(ItemId item, Ends end, bool covered);

  std::vector<std::uint64_t> bits_;    // two per item
  std::vector<std::uint64_t> covers_;  // rising: covering item << 32 | covered item << 1 | its end is the top
  std::vector<std::uint32_t> first_;   // per 32 items: first of covers_
  std::size_t count_ = 0;
};

}  // namespace sightline::core
