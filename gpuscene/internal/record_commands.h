// How records are drawn without attributes: one vertex or two each, indexed 0, 1, 2, …, many records to a command.
// Internal to gpuscene.
#pragma once

#include <cstdint>

#include "sightline/gpuscene/internal/draw_lists.h"

namespace sightline::gpuscene {

/// Records per command: their vertices must stay within 16-bit indices.
inline constexpr std::uint32_t kRecordsPerCommand = 8192;

/// Vertices that draw a record of a batch that has no attributes. Lines have two ends; what is ray-cast is a point,
/// which a geometry stage makes a proxy of.
constexpr std::uint32_t vertices_per_record(BatchKind kind) {
  return kind == BatchKind::kLine ? 2 : 1;
}

}  // namespace sightline::gpuscene
