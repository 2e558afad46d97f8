// How records are drawn without attributes: index patterns of their corners, many records to a command. Internal to
// gpuscene.
#pragma once

#include <array>
#include <cstdint>

#include "sightline/gpuscene/draw_lists.h"

namespace sightline::gpuscene {

/// Records per command: eight corners each must stay within 16-bit indices, and the index patterns should stay small.
inline constexpr std::uint32_t kRecordsPerCommand = 2048;

/// Corner c of a box has bits x = c & 1, y = c >> 1 & 1, z = c >> 2, set on the side towards the viewer. These are the
/// three faces on those sides, counter-clockwise from outside when bit set means the larger coordinate.
inline constexpr std::array<std::uint16_t, 18> kProxyIndices = {1, 3, 7, 1, 7, 5, 2, 6, 7, 2, 7, 3, 4, 5, 7, 4, 7, 6};
inline constexpr std::uint32_t kProxyIndexCount = kProxyIndices.size();
inline constexpr std::uint32_t kLineIndexCount = 2;

struct IndexPattern {
  std::uint32_t first_index, per_record;
  std::int32_t vertices_per_record;
};

/// Where a batch's pattern lies in corner_indices(): proxies, then lines, kRecordsPerCommand repeats each.
inline IndexPattern pattern_of(BatchKind kind) {
  if (kind == BatchKind::kLine) return {kRecordsPerCommand * kProxyIndexCount, kLineIndexCount, kLineIndexCount};
  return {0, kProxyIndexCount, kCornersPerRecord};
}

}  // namespace sightline::gpuscene
