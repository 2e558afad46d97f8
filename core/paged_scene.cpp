#include "sightline/core/paged_scene.h"

#include "sightline/core/internal/access.h"

namespace sightline::core {

void Page::drop_records() {
  for (int kind = 0; kind < kPrimitiveKindCount; ++kind) {
    KindItems& items = Access::of(snapshot).kind_items()[std::size_t(kind)];
    items.placements = {};
    items.parameters = {};
  }
}

}  // namespace sightline::core
