#include "sightline/core/paged_scene.h"

#include "sightline/core/internal/access.h"

namespace sightline::core {

std::span<const MeshDeviation> Page::deviations_of(std::uint32_t mesh) const {
  if (mesh >= deviation_ends.size()) return {};
  const std::uint32_t first = mesh == 0 ? 0 : deviation_ends[mesh - 1];
  return std::span(deviations).subspan(first, deviation_ends[mesh] - first);
}

void Page::drop_records() {
  for (int kind = 0; kind < kPrimitiveKindCount; ++kind) {
    KindItems& items = Access::of(snapshot).kind_items()[std::size_t(kind)];
    items.placements = {};
    items.parameters = {};
  }
}

}  // namespace sightline::core
