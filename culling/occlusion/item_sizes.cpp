#include "sightline/culling/occlusion/internal/item_sizes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sightline::culling {
namespace {

constexpr std::uint64_t kLookedAt = 128;
constexpr double kMostArea = 1e4;

/// Calls visit(slot) for the middle one of each `step` slots of a set.
template <class Visit>
void for_each_of_some(const core::VisibleSet& set, std::uint64_t step, const Visit& visit) {
  std::uint64_t next = step / 2, passed = 0;
  for (const core::SlotRange& range : set.ranges) {
    for (; next < passed + range.count; next += step) visit(core::Slot(range.first + (next - passed)));
    passed += range.count;
  }
  for (; next < passed + set.single_slots.size(); next += step) visit(set.single_slots[next - passed]);
}

}  // namespace

double mean_area(const core::View& view, const core::ItemBounds& bounds, const core::VisibleSet& set, int height) {
  const core::dvec3 eye = view.eye() - bounds.origin;
  const double scale = 0.5 * height * std::abs(view.clip_from_eye()[1][1]);
  double sum = 0.0;
  std::uint64_t count = 0;
  for_each_of_some(set, std::max<std::uint64_t>(1, set.count() / kLookedAt), [&](core::Slot slot) {
    if (bounds.vacant(slot)) return;
    const core::Aabb box = bounds.box(slot);
    const core::dvec3 to_box = core::dvec3(0.5f * (box.min + box.max)) - eye;
    const double size = scale * double(glm::length(box.max - box.min));
    const double area = view.orthographic() ? size * size : size * size / glm::dot(to_box, to_box);
    sum += std::min(area, kMostArea);
    ++count;
  });
  return count > 0 ? sum / double(count) : 0.0;
}

}  // namespace sightline::culling
