#include "sightline/core/item_bounds.h"

#include <algorithm>
#include <cassert>
#include <vector>

namespace sightline::core {
namespace {

bool surely_empty(const Aabb& box) {
  return box.min.x > box.max.x || box.min.y > box.max.y || box.min.z > box.max.z;
}

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
  std::vector<float> values;
  const auto gather = [&](auto value_of) {
    values.clear();
    for (std::size_t i = 0; i < size(); ++i)
      if (shown(i, mask)) values.push_back(value_of(i));
  };
  const auto smallest = [&](std::size_t n) {
    const auto place = values.begin() + std::ptrdiff_t(n);
    std::nth_element(values.begin(), place, values.end());
    return *place;
  };
  vec3 middle{0.0f};
  for (int axis = 0; axis < 3; ++axis) {
    const float *low = coordinate(axis), *high = coordinate(axis + 3);
    gather([&](std::size_t i) { return 0.5f * low[i] + 0.5f * high[i]; });
    if (values.size() < kShare) return {world_bounds(mask), 0};
    middle[axis] = smallest(values.size() / 2);
  }
  const auto reach = [&](std::size_t i) {
    const Aabb b = box(i);
    const vec3 far = glm::max(middle - b.min, b.max - middle);
    return std::max({far.x, far.y, far.z});
  };
  gather(reach);
  const double limit = kStretch * double(smallest(values.size() - values.size() / kShare - 1));
  Aabb rest;
  std::size_t outliers = 0;
  for (std::size_t i = 0; i < size(); ++i) {
    if (!shown(i, mask)) continue;
    if (limit > 0.0 && double(reach(i)) > limit)
      ++outliers;
    else
      rest.grow(box(i));
  }
  return {in_world(rest), outliers};
}

std::size_t ItemBounds::memory_bytes() const {
  std::size_t bytes = layers_.capacity() * sizeof(std::uint32_t);
  for (const auto& c : coordinates_) bytes += c.capacity() * sizeof(float);
  return bytes;
}

}  // namespace sightline::core
