#include "sightline/core/item_bounds.h"

#include <algorithm>
#include <cassert>

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

void ItemBounds::set(std::size_t i, const Aabb& box) {
  assert(i < size());
  const Aabb kept = surely_empty(box) ? Aabb{} : box;
  for (int axis = 0; axis < 3; ++axis) {
    coordinates_[axis][i] = kept.min[axis];
    coordinates_[axis + 3][i] = kept.max[axis];
  }
  if (!kept.empty()) extent_.grow(kept);
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

std::size_t ItemBounds::memory_bytes() const {
  std::size_t bytes = layers_.capacity() * sizeof(std::uint32_t);
  for (const auto& c : coordinates_) bytes += c.capacity() * sizeof(float);
  return bytes;
}

}  // namespace sightline::core
