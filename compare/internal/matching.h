// Pairs the items of two revisions. Internal.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/compare/internal/geometry.h"

namespace sightline::compare {

inline constexpr std::uint32_t kFree = ~std::uint32_t{0};

/// An item in tree order, with hashes of the names above it.
struct Entry {
  Geometry geometry;
  std::uint64_t path = 0;         ///< names from below the top down to the node
  std::uint64_t parent_path = 0;  ///< the same of the node's parent
  std::uint64_t key = 0;          ///< path with the order among equal names, and the order in the node
  core::NodeId node;
  core::ItemId item = core::kNone;
  std::uint32_t material = core::kNone;  ///< index, inherited
  std::uint32_t partner = kFree;         ///< entry of the other revision
};

/// One revision.
struct Side {
  Shapes shapes;
  std::vector<Entry> entries;

  Shown shown(std::uint32_t i) const { return {shapes, entries[i].item, entries[i].geometry}; }
};

/// Sets the partners of both sides, as compare.h says.
void match(Side& before, Side& after, double tolerance);

}  // namespace sightline::compare
