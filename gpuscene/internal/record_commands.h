// How records are drawn without attributes: one or two vertices each, with indices 0, 1, 2, …, and many records per
// command. Internal to gpuscene.
#pragma once

#include <cstdint>

#include "sightline/gpuscene/internal/draw_lists.h"

namespace sightline::gpuscene {

/// Records per command: their vertices must fit 16-bit indices.
inline constexpr std::uint32_t kRecordsPerCommand = 8192;

/// Vertices per record of a batch without attributes. Lines have two ends; a ray-cast item is a point, which a geometry
/// stage makes a proxy.
constexpr std::uint32_t vertices_per_record(BatchKind kind) {
  return kind == BatchKind::kLine ? 2 : 1;
}

}  // namespace sightline::gpuscene
