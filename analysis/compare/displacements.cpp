#include "sightline/analysis/compare/internal/displacements.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "sightline/analysis/compare/internal/cells.h"

namespace sightline::compare {
namespace {

constexpr double kTurnCell = 1e-3;       // radians
constexpr double kSameDirection = 2e-6;  // placements are single precision
constexpr std::size_t kMostTried = 64;

core::Affine map_of(const Displacement& d) {
  if (!d.turned()) return core::translation(d.offset);
  const core::Affine &from = d.world_from_item_before, &to = d.world_from_item_after;
  const core::dmat3 linear = to.linear * glm::inverse(from.linear);
  return {linear, to.origin - linear * from.origin};
}

/// Calls visit(hash) for the cell of `coordinates` from the c-th on and the cells beside it, the own one first.
template <class Visit>
void each_near_cell(std::uint64_t hash, const double* coordinates, int count, double size, const Visit& visit) {
  if (count == 0) return visit(hash);
  const double own = std::floor(*coordinates / size);
  for (const double cell : {own, own - 1.0, own + 1.0})
    each_near_cell(with_cell(hash, cell), coordinates + 1, count - 1, size, visit);
}

}  // namespace

bool Displacements::fits(const Class& known, const Displacement& d) const {
  if (known.turned != d.turned()) return false;
  if (!known.turned) return glm::length(known.map.origin - d.offset) <= slack_;
  const core::dvec3 &from = d.world_from_item_before.origin, &to = d.world_from_item_after.origin;
  const double distance = glm::length(from - known.at);
  if (!(glm::length(core::transform_point(known.map, from) - to) <= slack_ + kSameDirection * distance)) return false;
  const core::dmat3 off = known.map.linear * d.world_from_item_before.linear - d.world_from_item_after.linear;
  const core::dmat3& placed = d.world_from_item_after.linear;
  for (int axis = 0; axis < 3; ++axis)
    if (!(glm::length(off[axis]) <= kLeastTurn * glm::length(placed[axis]))) return false;
  return true;
}

std::uint32_t Displacements::class_of(const Displacement& d) {
  if (last_ < classes_.size() && fits(classes_[last_], d)) return last_;
  constexpr auto kNoClass = ~std::uint32_t{0};
  std::uint32_t found = kNoClass;
  const double coordinates[] = {d.offset.x, d.offset.y, d.offset.z};
  const std::uint64_t start = d.turned() ? 1 : 2;
  const double* first = d.turned() ? &d.turn : coordinates;
  const int count = d.turned() ? 1 : 3;
  const double size = d.turned() ? kTurnCell : 4.0 * slack_;
  std::uint64_t own = 0;
  each_near_cell(start, first, count, size, [&](std::uint64_t cell) {
    if (own == 0) own = cell;
    const auto known = by_cell_.find(cell);
    if (found != kNoClass || known == by_cell_.end()) return;
    const auto& in_cell = known->second;
    const auto stop = in_cell.rbegin() + std::ptrdiff_t(std::min(in_cell.size(), kMostTried));
    const auto fitting = std::find_if(in_cell.rbegin(), stop, [&](std::uint32_t i) { return fits(classes_[i], d); });
    if (fitting != stop) found = *fitting;
  });
  if (found == kNoClass) {
    found = std::uint32_t(classes_.size());
    classes_.push_back({map_of(d), d.world_from_item_before.origin, d.turned()});
    by_cell_[own].push_back(found);
  }
  return last_ = found;
}

}  // namespace sightline::compare
