// Chunks of a site: float offsets of items count from the origin of a chunk nearby, so that their precision follows the
// item and not the site. Internal to snapshots.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "sightline/core/conventions.h"

namespace sightline::core {

class ChunkGrid {
 public:
  /// Starts anew: cuts a sequence of points, of which neighbours should lie near each other, into runs of chunk size,
  /// and tells the chunk of each. Chunks are 16 m wide, which resolves a micrometre, or twice that until they are few.
  std::vector<std::uint32_t> cut(const std::vector<dvec3>& points);

  /// A chunk within reach of `place`: `own`, a likely one (either may be kNone), any other, or a new one about `fresh`,
  /// which must lie within reach itself. Once new ones are too many, a chunk that is farther away.
  std::uint32_t find(const dvec3& place, std::uint32_t own, std::uint32_t likely, const dvec3& fresh);

  /// Multiples of a 1024th of the size: an offset then loses nothing on its way from one chunk to another, since float
  /// resolves 2^-24 of a chunk and everything is a multiple of that.
  const std::vector<dvec3>& origins() const { return origins_; }
  double size() const { return size_; }  ///< metres
  std::size_t memory_bytes() const { return origins_.capacity() * sizeof(dvec3) + cells_.size() * 32; }

 private:
  bool reaches(std::uint32_t chunk, const dvec3& place) const;
  std::uint64_t cell_of(const dvec3& place, const dvec3& step = dvec3(0.0)) const;

  std::vector<dvec3> origins_;
  std::unordered_map<std::uint64_t, std::uint32_t> cells_;  // a chunk whose origin lies there
  double size_ = 0.0;
};

}  // namespace sightline::core
