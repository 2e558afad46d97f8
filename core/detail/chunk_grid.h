// Chunks of a site. The float offset of an item is relative to the origin of a nearby chunk, so that its precision
// follows the item and not the site. Internal to snapshots.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/conventions.h"

namespace sightline::core {

class SIGHTLINE_API ChunkGrid {
 public:
  /// Starts anew. Cuts a sequence of points, in which neighbours should lie near each other, into runs that fit into a
  /// chunk. Returns the chunk of each point. Chunks are 16 m wide, which resolves a micrometre; the width doubles until
  /// there are few enough chunks.
  std::vector<std::uint32_t> cut(std::span<const dvec3> points);

  /// A chunk within reach of `place`. Tries `own`, then `likely` (either may be kNone), then all others. Then adds a
  /// chunk about `fresh`, which must lie within reach of `place`. Once too many chunks were added, returns one that is
  /// farther away.
  std::uint32_t find(const dvec3& place, std::uint32_t own, std::uint32_t likely, const dvec3& fresh);

  /// Origins are multiples of 1/1024 of the chunk size. So an offset loses nothing when it moves from one chunk to
  /// another: float resolves 2^-24 of a chunk, and everything is a multiple of that.
  const std::vector<dvec3>& origins() const { return origins_; }
  double size() const { return size_; }  ///< metres
  /// As cut() left a grid with this size and these origins.
  static ChunkGrid restored(double size, std::vector<dvec3> origins);
  std::size_t memory_bytes() const { return origins_.capacity() * sizeof(dvec3) + cells_.size() * 32; }

 private:
  void index();
  bool reaches(std::uint32_t chunk, const dvec3& place) const;
  std::uint64_t cell_of(const dvec3& place, const dvec3& step = dvec3(0.0)) const;

  std::vector<dvec3> origins_;
  std::unordered_map<std::uint64_t, std::uint32_t> cells_;  // a chunk whose origin lies in the cell
  double size_ = 0.0;
};

}  // namespace sightline::core
