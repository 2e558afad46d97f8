// Bounds and layers of items as flat arrays: the part of a snapshot that a culler reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "sightline/core/aabb.h"
#include "sightline/core/api.h"
#include "sightline/core/large_array.h"

namespace sightline::core {

/// What a view of a whole model should show.
struct FittedBounds {
  AabbD bounds;              ///< in the world; empty when there is nothing to see
  std::size_t outliers = 0;  ///< boxes that were left out
};

/// Slots per block. A block is a leaf of the culler's hierarchy, and an edited item either stays in its block or leaves
/// it.
inline constexpr std::uint32_t kBlockSlots = 32;

/// Structure-of-arrays boxes, relative to `origin` and rounded outwards. The six coordinate arrays are padded with
/// kPadding empty boxes beyond size(), so that a group of kPadding may be read from any valid index.
///
/// A slot with the empty box is vacant: it has nothing to draw and fails every plane test.
class SIGHTLINE_API ItemBounds {
 public:
  static constexpr std::size_t kPadding = 16;

  dvec3 origin{0.0};

  std::size_t size() const { return size_; }
  void resize(std::size_t count);   ///< new boxes are empty, new layers kLayerModel
  void reserve(std::size_t count);  ///< allocates memory for resize() to grow into
  /// Stores the empty box for any box that is surely empty. A box with a NaN is not surely empty, so its item is drawn.
  void set(std::size_t i, const Aabb& box);
  /// set() for several threads, each with boxes of its own. The box is not empty or the default one; extent() stays as
  /// it is and must be set afterwards.
  void store(std::size_t i, const Aabb& box);
  void set_extent(const Aabb& extent) { extent_ = extent; }
  Aabb box(std::size_t i) const;
  AabbD in_world(const Aabb& box) const;  ///< of a box relative to `origin`
  bool vacant(std::size_t i) const { return coordinates_[0][i] > coordinates_[3][i]; }
  void set_layers(std::size_t i, std::uint32_t layers);  ///< not 0: to hide an item give it the empty box
  std::uint32_t layers(std::size_t i) const { return layers_.empty() ? std::uint32_t(kLayerModel) : layers_[i]; }
  /// False while every item has always been on kLayerModel alone. Then no layers are stored and none need be tested.
  bool uses_layers() const { return uses_layers_; }
  /// Union of all boxes ever set, or what set_extent() made of it: a bound for coordinate magnitudes.
  const Aabb& extent() const { return extent_; }

  /// Union of the boxes on any of `layers`, in world coordinates: the boxes that views with this layer mask can show.
  AabbD world_bounds(std::uint32_t layers = kDefaultLayerMask) const;
  /// Bounds without outliers, for views of the whole model: a few items far away must not make all others small.
  ///
  /// The rule: the middle is the median of the boxes' centres, axis by axis. The reach of a box is how far it extends
  /// from the middle along any axis. R is the reach that 99 % of the boxes (of n boxes, n - floor(n / 100)) do not
  /// exceed. A box is an outlier when its reach exceeds 4 R: together with the others of its hundredth it would stretch
  /// the view more than fourfold. So at most 1 % of the boxes are outliers, and no box of fewer than a hundred is one.
  /// Where R is 0 there are no outliers. Expected time is linear in the number of boxes, with up to twelve bytes of
  /// memory per box.
  FittedBounds fitted_bounds(std::uint32_t layers = kDefaultLayerMask) const;

  /// Coordinate arrays in the order min x, min y, min z, max x, max y, max z.
  const float* coordinate(int axis) const { return coordinates_[axis].data(); }
  std::span<const std::uint32_t> layers() const { return layers_; }  ///< empty unless uses_layers()
  std::size_t memory_bytes() const;

 private:
  friend class Access;
  friend class Snapshot;
  void resize_for_overwrite(std::size_t count, bool with_layers);
  bool shown(std::size_t i, std::uint32_t mask) const { return !vacant(i) && (layers(i) & mask) != 0; }
  LargeArray<float> coordinates_[6];
  LargeArray<std::uint32_t> layers_;
  std::size_t size_ = 0;
  Aabb extent_;
  bool uses_layers_ = false;
};

}  // namespace sightline::core
