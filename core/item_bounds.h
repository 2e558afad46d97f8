// Bounds and layers of items as flat arrays: the part of a snapshot that a culler reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/aabb.h"

namespace sightline::core {

/// Memory that starts at a cache line, so that a group of sixteen floats is one line and not two. From 4 MiB on it asks
/// for huge pages (Linux): a query touches thousands of places far apart, and the misses of small pages cost 5 to 10 %.
void* allocate_lines(std::size_t bytes);
void release_lines(void* memory, std::size_t bytes);

template <class T>
struct CacheLineAllocator {
  using value_type = T;
  CacheLineAllocator() = default;
  template <class U>
  explicit CacheLineAllocator(const CacheLineAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(allocate_lines(n * sizeof(T))); }
  void deallocate(T* p, std::size_t n) { release_lines(p, n * sizeof(T)); }
  friend bool operator==(const CacheLineAllocator&, const CacheLineAllocator&) { return true; }
};

/// Structure-of-arrays boxes, relative to `origin` and rounded outwards. The six coordinate arrays are padded with
/// kPadding empty boxes beyond size(), so that a group of kPadding may be read from any valid index.
///
/// A place with the empty box is vacant: there is nothing to draw, and no plane lets it pass.
class ItemBounds {
 public:
  static constexpr std::size_t kPadding = 16;

  dvec3 origin{0.0};

  std::size_t size() const { return size_; }
  void resize(std::size_t count);   ///< new boxes are empty, new layers kLayerModel
  void reserve(std::size_t count);  ///< memory for so many, for resize() to grow into
  /// Any box that is surely empty becomes the empty box. One with a NaN is not, so it is drawn.
  void set(std::size_t i, const Aabb& box);
  Aabb box(std::size_t i) const;
  bool vacant(std::size_t i) const { return coordinates_[0][i] > coordinates_[3][i]; }
  void set_layers(std::size_t i, std::uint32_t layers);  ///< not 0: to hide an item give it the empty box
  std::uint32_t layers(std::size_t i) const { return layers_.empty() ? std::uint32_t(kLayerModel) : layers_[i]; }
  /// False while no item has ever been off kLayerModel: then nobody needs to look at layers, and none are kept.
  bool uses_layers() const { return uses_layers_; }
  /// Union of all boxes ever set: a bound for coordinate magnitudes.
  const Aabb& extent() const { return extent_; }

  /// Coordinate arrays in the order min x, min y, min z, max x, max y, max z.
  const float* coordinate(int axis) const { return coordinates_[axis].data(); }
  std::span<const std::uint32_t> layers() const { return layers_; }  ///< empty unless uses_layers()
  std::size_t memory_bytes() const;

 private:
  std::vector<float, CacheLineAllocator<float>> coordinates_[6];
  std::vector<std::uint32_t> layers_;
  std::size_t size_ = 0;
  Aabb extent_;
  bool uses_layers_ = false;
};

}  // namespace sightline::core
