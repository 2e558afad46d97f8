#include "sightline/core/item_bounds.h"

#include <algorithm>
#include <cassert>

namespace sightline::core {

void ItemBounds::resize(std::size_t count) {
  const Aabb empty;
  const std::size_t old = size();
  for (int axis = 0; axis < 6; ++axis) {
    const float value = axis < 3 ? empty.min[axis] : empty.max[axis - 3];
    coordinates_[axis].resize(count + kPadding, value);
    if (count < old) std::fill(coordinates_[axis].begin() + std::ptrdiff_t(count), coordinates_[axis].end(), value);
  }
  layers_.resize(count, kLayerModel);
}

void ItemBounds::set(std::size_t i, const Aabb& box) {
  assert(i < size());
  for (int axis = 0; axis < 3; ++axis) {
    coordinates_[axis][i] = box.min[axis];
    coordinates_[axis + 3][i] = box.max[axis];
  }
  if (!box.empty()) extent_.grow(box);
}

Aabb ItemBounds::box(std::size_t i) const {
  assert(i < size());
  return {{coordinates_[0][i], coordinates_[1][i], coordinates_[2][i]},
          {coordinates_[3][i], coordinates_[4][i], coordinates_[5][i]}};
}

void ItemBounds::set_layers(std::size_t i, std::uint32_t layers) {
  assert(i < size());
  layers_[i] = layers;
  uses_layers_ = uses_layers_ || layers != kLayerModel;
}

std::size_t ItemBounds::memory_bytes() const {
  std::size_t bytes = layers_.capacity() * sizeof(std::uint32_t);
  for (const auto& c : coordinates_) bytes += c.capacity() * sizeof(float);
  return bytes;
}

}  // namespace sightline::core
