#include "sightline/core/item_bounds.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <numeric>
#include <vector>

namespace sightline::core {
namespace {

bool surely_empty(const Aabb& box) {
  return box.min.x > box.max.x || box.min.y > box.max.y || box.min.z > box.max.z;
}

/// Finds the nth smallest of many values in two passes over them. The first shares them out among equal intervals; the
/// second keeps those of the interval that holds the answer, a few thousandths of all as a rule.
class Selection {
 public:
  /// Values lie between these, or count as the nearer one does.
  Selection(float least, float most) : least_(least), scale_(float(kIntervals) / (most - least)) {}

  void count(float value) { ++counts_[interval(value)]; }
  std::size_t counted() const { return std::accumulate(counts_.begin(), counts_.end(), std::size_t(0)); }
  /// After all are counted, n from 0. Makes room for what keep() keeps.
  void choose(std::size_t n) {
    for (rank_ = n; rank_ >= counts_[chosen_]; ++chosen_) rank_ -= counts_[chosen_];
    kept_.reserve(counts_[chosen_]);
  }
  void keep(float value) {
    if (interval(value) == chosen_) kept_.push_back(value);
  }
  float value() {
    const auto place = kept_.begin() + std::ptrdiff_t(rank_);
    std::nth_element(kept_.begin(), place, kept_.end());
    return *place;
  }

 private:
  static constexpr std::size_t kIntervals = 4096;
  /// Grows with the value, whatever is rounded.
  std::size_t interval(float value) const {
    const float place = (value - least_) * scale_;
    return place > 0.0f ? std::size_t(std::min(place, float(kIntervals - 1))) : std::size_t(0);
  }

  float least_, scale_;
  std::array<std::size_t, kIntervals> counts_{};
  std::size_t chosen_ = 0, rank_ = 0;
  std::vector<float> kept_;
};

}  // namespace

void ItemBounds::resize(std::size_t count) {
  const Aabb empty;
  for (int axis = 0; axis < 6; ++axis) {
    const float value = axis < 3 ? empty.min[axis] : empty.max[axis - 3];
    coordinates_[axis].resize(count + kPadding, value);
    if (count < size_) std::fill(coordinates_[axis].begin() + std::ptrdiff_t(count), coordinates_[axis].end(), value);
  }
  if (uses_layers_) layers_.resize(count, kLayerModel);
  size_ = count;
}

void ItemBounds::reserve(std::size_t count) {
  for (auto& c : coordinates_) c.reserve(count + kPadding);
}

/// Leaves boxes and layers unset, all but the padding.
void ItemBounds::resize_for_overwrite(std::size_t count, bool with_layers) {
  size_ = 0;
  for (auto& c : coordinates_) c.resize_for_overwrite(count);
  resize(count);
  for (auto& c : coordinates_) c.spare_room();
  uses_layers_ = with_layers;
  if (with_layers) layers_.resize_for_overwrite(count);
}

void ItemBounds::set(std::size_t i, const Aabb& box) {
  const Aabb kept = surely_empty(box) ? Aabb{} : box;
  store(i, kept);
  if (!kept.empty()) extent_.grow(kept);
}

void ItemBounds::store(std::size_t i, const Aabb& box) {
  assert(i < size());
  for (int axis = 0; axis < 3; ++axis) {
    coordinates_[axis][i] = box.min[axis];
    coordinates_[axis + 3][i] = box.max[axis];
  }
}

Aabb ItemBounds::box(std::size_t i) const {
  assert(i < size());
  return {{coordinates_[0][i], coordinates_[1][i], coordinates_[2][i]},
          {coordinates_[3][i], coordinates_[4][i], coordinates_[5][i]}};
}

void ItemBounds::set_layers(std::size_t i, std::uint32_t layers) {
  assert(i < size() && layers != 0);
  if (layers != kLayerModel && !uses_layers_) {
    uses_layers_ = true;
    layers_.assign(size_, kLayerModel);
  }
  if (uses_layers_) layers_[i] = layers;
}

AabbD ItemBounds::in_world(const Aabb& box) const {
  if (box.empty()) return {};
  return {dvec3(box.min) + origin, dvec3(box.max) + origin};
}

AabbD ItemBounds::world_bounds(std::uint32_t mask) const {
  Aabb all;
  for (std::size_t i = 0; i < size(); ++i)
    if (shown(i, mask)) all.grow(box(i));
  return in_world(all);
}

FittedBounds ItemBounds::fitted_bounds(std::uint32_t mask) const {
  constexpr std::size_t kShare = 100;  // one box of so many may be an outlier
  constexpr double kStretch = 4.0;
  const auto for_each_shown = [&](const auto& visit) {
    for (std::size_t i = 0; i < size(); ++i)
      if (shown(i, mask)) visit(i);
  };
  std::array<Selection, 3> centres{Selection(extent_.min.x, extent_.max.x), Selection(extent_.min.y, extent_.max.y),
                                   Selection(extent_.min.z, extent_.max.z)};
  const auto for_each_centre = [&](const auto& visit) {
#pragma omp parallel for schedule(static, 1) if (size() > 65536)
    for (int axis = 0; axis < 3; ++axis) {
      const float *low = coordinate(axis), *high = coordinate(axis + 3);
      Selection& selection = centres[std::size_t(axis)];
      for_each_shown([&](std::size_t i) { visit(selection, 0.5f * low[i] + 0.5f * high[i]); });
    }
  };
  for_each_centre([](Selection& selection, float centre) { selection.count(centre); });
  const std::size_t count = centres[0].counted();
  if (count < kShare) return {world_bounds(mask), 0};
  for (Selection& selection : centres) selection.choose(count / 2);
  for_each_centre([](Selection& selection, float centre) { selection.keep(centre); });
  const vec3 middle(centres[0].value(), centres[1].value(), centres[2].value());

  const auto reach_of = [&](const Aabb& b) {
    const vec3 far = glm::max(middle - b.min, b.max - middle);
    return std::max({far.x, far.y, far.z});
  };
  Selection reaches(0.0f, reach_of(extent_));
  for_each_shown([&](std::size_t i) { reaches.count(reach_of(box(i))); });
  reaches.choose(count - count / kShare - 1);
  for_each_shown([&](std::size_t i) { reaches.keep(reach_of(box(i))); });
  const double limit = kStretch * double(reaches.value());
  Aabb rest;
  std::size_t outliers = 0;
  for_each_shown([&](std::size_t i) {
    const Aabb b = box(i);
    if (limit > 0.0 && double(reach_of(b)) > limit)
      ++outliers;
    else
      rest.grow(b);
  });
  return {in_world(rest), outliers};
}

std::size_t ItemBounds::memory_bytes() const {
  std::size_t bytes = layers_.capacity() * sizeof(std::uint32_t);
  for (const auto& c : coordinates_) bytes += c.capacity() * sizeof(float);
  return bytes;
}

}  // namespace sightline::core
