#include "sightline/culling/occlusion/internal/solid_areas.h"

#include <cmath>
#include <limits>
#include <unordered_map>

#include "sightline/core/surface_area.h"

namespace sightline::culling {
namespace {

constexpr std::size_t kTimedPiece = 4096;  // slots between looks at the clock

double surface_of(const core::Snapshot& snapshot, core::Slot slot) {
  return int(snapshot.kind(slot)) >= core::kPrimitiveKindCount ? core::surface_area(snapshot.mesh(slot))
                                                               : core::surface_area(snapshot.primitive(slot));
}

float projected(double surface, const core::Snapshot& snapshot, core::Slot slot) {
  const double volume = std::abs(glm::determinant(snapshot.world_from_item(slot).linear));
  if (!(volume > 0.0)) return std::numeric_limits<float>::infinity();
  const double scale = std::cbrt(volume);
  return float(0.25 * surface * scale * scale);
}

/// Areas of items. Looks at each mesh once.
class Measure {
 public:
  explicit Measure(const core::Snapshot& snapshot) : snapshot_(snapshot) {}

  float operator()(core::Slot slot) {
    const core::Kind kind = snapshot_.kind(slot);
    if (snapshot_.vacant(slot)) return 0.0f;
    if (int(kind) < core::kPrimitiveKindCount) return mean_projected_area(snapshot_, slot);
    const std::uint32_t mesh = snapshot_.of_kind(kind).meshes[snapshot_.index_in_kind(slot)];
    const auto [place, fresh] = of_mesh_.try_emplace(mesh);
    if (fresh) place->second = surface_of(snapshot_, slot);
    return projected(place->second, snapshot_, slot);
  }

 private:
  const core::Snapshot& snapshot_;
  std::unordered_map<std::uint32_t, double> of_mesh_;
};

}  // namespace

float mean_projected_area(const core::Snapshot& snapshot, core::Slot slot) {
  return projected(surface_of(snapshot, slot), snapshot, slot);
}

std::span<const float> SolidAreas::of(const core::Snapshot& snapshot) {
  measure(snapshot, core::kNoDeadline);
  return areas_;
}

bool SolidAreas::measure(const core::Snapshot& snapshot, core::Deadline deadline) {
  Measure measure(snapshot);
  if (areas_.empty()) areas_.reserve(snapshot.size());
  while (areas_.size() < snapshot.size()) {
    areas_.push_back(measure(core::Slot(areas_.size())));
    if (areas_.size() % kTimedPiece == 0 && core::over(deadline)) break;
  }
  return areas_.size() == snapshot.size();
}

void SolidAreas::update(const core::Snapshot& snapshot, std::span<const core::Slot> touched) {
  Measure measure(snapshot);
  for (const core::Slot slot : touched)
    if (slot < areas_.size()) areas_[slot] = measure(slot);
}

}  // namespace sightline::culling
