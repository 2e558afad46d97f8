// What a click takes: an item, or the part, the assembly or the file that it belongs to.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sightline/core/scene.h"

namespace sightline::apps {

enum class SelectionLevel : std::uint8_t { kItem, kPart, kAssembly, kFile };
inline constexpr std::array kLevelNames = {"item", "part", "assembly", "file"};
inline const char* name_of(SelectionLevel level) {
  return kLevelNames[std::size_t(level)];
}

/// What a level makes of an item.
struct Taken {
  core::ItemId item;
  core::NodeId node;                ///< all below it; invalid: the item alone
  std::vector<core::ItemId> items;  ///< in rising order
};

/// Parts are those of core::part_of(); one that is in no other is its own assembly. The node is invalid where there is
/// none of that level.
core::NodeId node_at(const core::Scene& scene, core::ItemId item, SelectionLevel level);
Taken taken_at(const core::Scene& scene, core::ItemId item, SelectionLevel level);

/// The items as groups, each of which is what one of them takes, less what does not count. Where `whole` says so, only
/// groups of which no item is missing; otherwise all.
std::vector<std::vector<core::ItemId>> groups_of(const core::Scene& scene, std::span<const core::ItemId> items,
                                                 SelectionLevel level, bool whole,
                                                 const std::function<bool(core::ItemId)>& counts);

}  // namespace sightline::apps
