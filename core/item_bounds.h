// Bounds and layers of items as flat arrays: the part of a snapshot that a culler reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <vector>

#include "sightline/core/aabb.h"

namespace sightline::core {

/// Starts arrays at cache lines, so that a group of sixteen floats is one line and not two.
template <class T>
struct CacheLineAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{64};
  CacheLineAllocator() = default;
  template <class U>
  explicit CacheLineAllocator(const CacheLineAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), kAlignment)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, kAlignment); }
  friend bool operator==(const CacheLineAllocator&, const CacheLineAllocator&) { return true; }
};

/// Structure-of-arrays boxes, relative to `origin` and rounded outwards. The six coordinate arrays are padded with
/// kPadding empty boxes beyond size(), so that a group of kPadding may be read from any valid index.
class ItemBounds {
 public:
  static constexpr std::size_t kPadding = 16;

  dvec3 origin{0.0};

  std::size_t size() const { return layers_.size(); }
  void resize(std::size_t count);  ///< new boxes are empty, new layers kLayerModel
  void set(std::size_t i, const Aabb& box);
  Aabb box(std::size_t i) const;
  void set_layers(std::size_t i, std::uint32_t layers);  ///< 0: never visible (hidden or removed)
  std::uint32_t layers(std::size_t i) const { return layers_[i]; }
  /// False while every item is on kLayerModel alone: then nobody needs to look at layers.
  bool uses_layers() const { return uses_layers_; }
  /// Union of all boxes ever set: a bound for coordinate magnitudes.
  const Aabb& extent() const { return extent_; }

  /// Coordinate arrays in the order min x, min y, min z, max x, max y, max z.
  const float* coordinate(int axis) const { return coordinates_[axis].data(); }
  std::span<const std::uint32_t> layers() const { return layers_; }
  std::size_t memory_bytes() const;

 private:
  std::vector<float, CacheLineAllocator<float>> coordinates_[6];
  std::vector<std::uint32_t> layers_;
  Aabb extent_;
  bool uses_layers_ = false;
};

}  // namespace sightline::core
