// Internal to the importers: welds corners, which files hold one by one, into vertices that triangles share.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/conventions.h"

namespace sightline::importers {

/// Corners at exactly the same position (-0 is 0) become one vertex. Vertices keep the order of their first corners.
///
/// A hash table of vertex numbers with linear probing, at most half full. A block of corners is looked up in three
/// sweeps, each prefetching for the next; this hides most of the cost of a table larger than the caches. A vertex that
/// finds no place near its own (crafted files) is not welded: time is linear whatever the file holds.
class VertexWelder {
 public:
  static constexpr std::size_t kBlock = 768;  ///< best number of corners for one call of add()

  /// `vertices`: the expected number.
  explicit VertexWelder(std::size_t vertices = 0);

  /// Appends a vertex number per corner. All calls together may add fewer than 2^32 - 1 corners.
  void add(std::span<const core::dvec3> corners, std::vector<std::uint32_t>& numbers);

  std::vector<core::dvec3> take_positions();  ///< and resets the welder

 private:
  void grow(std::size_t vertices);
  std::uint32_t find_or_add(const core::dvec3& position, std::size_t place);

  std::vector<core::dvec3> positions_;
  std::vector<std::uint32_t> table_;  // vertex numbers, kNone where free; a power of two of them
  int shift_ = 64;                    // from a hash to an index into the table
};

}  // namespace sightline::importers
