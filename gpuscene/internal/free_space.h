// Which units of a row are taken: places for runs of them. Internal to gpuscene.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <utility>

namespace sightline::gpuscene {

/// Runs come into the smallest gap that has room, else to the end. Time logarithmic in the number of gaps. Gaps that
/// touch are one, and one at the end is none.
class FreeSpace {
 public:
  /// The first of `count` units that are taken from now on; of none, no matter which.
  std::uint32_t take(std::uint32_t count);
  /// Gives back what take() has returned, all of it.
  void give_back(std::uint32_t first, std::uint32_t count);
  std::uint32_t end() const { return end_; }    ///< beyond all that is taken
  std::uint32_t used() const { return used_; }  ///< number of units that are taken

 private:
  using Gap = std::pair<std::uint32_t, std::uint32_t>;
  void remove(std::map<std::uint32_t, std::uint32_t>::iterator gap);

  std::map<std::uint32_t, std::uint32_t> gaps_;  // first to count
  std::set<Gap> by_count_;                       // count, first
  std::uint32_t end_ = 0, used_ = 0;
};

}  // namespace sightline::gpuscene
