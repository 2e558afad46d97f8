// Pairs the items of two revisions. Internal.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "sightline/analysis/compare/internal/geometry.h"

namespace sightline::compare {

inline constexpr std::uint32_t kFree = ~std::uint32_t{0};

/// Reports what share of the work is done, and remembers whether to stop.
class Progress {
 public:
  explicit Progress(const std::function<bool(double)>& report) : report_(report) {}

  /// The next part of the work is the share `share` of all.
  void begin(double share) {
    from_ += share_;
    share_ = share;
    go_on(0, 1);
  }
  /// Asks after step i of n of this part, but not each time.
  bool go_on(std::size_t i, std::size_t n) {
    if (i % 4096 == 0 && report_ && !stopped_)
      stopped_ = !report_(std::min(1.0, from_ + share_ * double(i) / double(std::max<std::size_t>(n, 1))));
    return !stopped_;
  }
  bool stopped() const { return stopped_; }

 private:
  const std::function<bool(double)>& report_;
  double from_ = 0.0, share_ = 0.0;
  bool stopped_ = false;
};

/// An item in tree order, with hashes of the names above it.
struct Entry {
  Geometry geometry;
  std::uint64_t path = 0;         ///< names from below the top down to the node
  std::uint64_t parent_path = 0;  ///< the same of the node's parent
  std::uint64_t key = 0;          ///< path with the order among equal names, and the order in the node
  core::NodeId node;
  core::ItemId item = core::kNoItem;
  std::uint32_t material = core::kNone;  ///< index, inherited
  std::uint32_t partner = kFree;         ///< entry of the other revision
};

/// One revision.
struct Side {
  Shapes shapes;
  std::vector<Entry> entries;

  Shown shown(std::uint32_t i) const { return {shapes, entries[i].item, entries[i].geometry}; }
};

/// Sets the partners of both sides, as compare.h says; `share` of all work.
void match(Side& before, Side& after, double tolerance, Progress& progress, double share);

}  // namespace sightline::compare
