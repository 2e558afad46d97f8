// Internal to the importers: corners that files hold one by one become vertices that triangles share.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/conventions.h"

namespace sightline::importers {

/// Corners at exactly the same position (-0 is 0) become one vertex; vertices keep the order in which they came.
///
/// A hash table of vertex numbers, linear probing, at most half full. Looking a block of corners up in three sweeps,
/// each prefetching for the next, hides most of what a table larger than the caches costs. A vertex that finds no place
/// near its own (crafted files) stays alone: time is linear whatever the file holds.
class VertexWelder {
 public:
  static constexpr std::size_t kBlock = 768;  ///< corners that are best given at once

  /// `vertices`: how many are expected.
  explicit VertexWelder(std::size_t vertices = 0);

  /// Appends a vertex number per corner. Together fewer than 2^32 - 1 corners.
  void add(std::span<const core::dvec3> corners, std::vector<std::uint32_t>& numbers);

  std::vector<core::dvec3> take_positions();  ///< and starts anew

 private:
  void grow(std::size_t vertices);
  std::uint32_t find_or_add(const core::dvec3& position, std::size_t place);

  std::vector<core::dvec3> positions_;
  std::vector<std::uint32_t> table_;  // vertex numbers, kNone where free; a power of two of them
  int shift_ = 64;                    // of a hash, to a place in the table
};

}  // namespace sightline::importers
