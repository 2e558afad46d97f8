// A click takes an item, or the part, the assembly or the file that it belongs to.
#pragma once

#include <array>
#include <cstddef>
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

/// Holds what a level makes of an item.
struct Taken {
  core::ItemId item;
  core::NodeId node;                ///< all below it; invalid: the item alone
  std::vector<core::ItemId> items;  ///< in rising order
};

/// Parts are those of core::part_of(); one that is in no other is its own assembly. The node is invalid where there is
/// none of that level.
core::NodeId node_at(const core::Scene& scene, core::ItemId item, SelectionLevel level);
Taken taken_at(const core::Scene& scene, core::ItemId item, SelectionLevel level);

/// Groups items by the nodes of a level that they lie below, in the order of their first ones; an item without such a
/// node is a group by itself. Ends with the group that is the last of `most`, some of whose items may lack then.
std::vector<Taken> groups_of(const core::Scene& scene, std::span<const core::ItemId> items, SelectionLevel level,
                             std::size_t most = std::size_t(-1));
/// Returns what a level makes of each of these groups, less what does not count. Where `whole` says so, only groups of
/// which the items, in rising order, lack nothing; otherwise all.
std::vector<std::vector<core::ItemId>> taken_by(const core::Scene& scene, std::span<const core::ItemId> items,
                                                SelectionLevel level, bool whole,
                                                const std::function<bool(core::ItemId)>& counts);

}  // namespace sightline::apps
