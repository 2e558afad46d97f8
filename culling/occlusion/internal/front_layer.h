// Internal: which boxes the rays of an image enter first.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "sightline/core/internal/scratch.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/occlusion/internal/object_pool.h"

namespace sightline::culling {

/// For each pixel, the box that its ray enters first.
struct FrontLayer {
  void clear(std::size_t pixels) {
    nearest.assign(pixels, std::numeric_limits<float>::infinity());
    front_slot.assign(pixels, core::kNone);
    not_judged.clear();
  }
  void enter(std::size_t pixel, float distance, core::Slot slot) {
    float& known = nearest[pixel];
    if (!(distance < known || (distance == known && slot < front_slot[pixel]))) return;
    known = distance;
    front_slot[pixel] = slot;
  }
  std::size_t memory_bytes() const { return core::bytes_of(nearest, front_slot, not_judged); }

  std::vector<float> nearest;
  std::vector<core::Slot> front_slot;  // core::kNone: no box
  std::vector<core::Slot> not_judged;
};

/// One for each thread that enters boxes.
class FrontLayers {
 public:
  void begin(std::size_t pixels) {
    pixels_ = pixels;
    layers_.begin();
  }
  FrontLayer& take() {
    return layers_.take([&](FrontLayer& layer) { layer.clear(pixels_); });
  }
  void give_back(FrontLayer& layer) { layers_.give_back(layer); }
  /// Sets the bits of the slots that belong to the front. Afterwards the layers hold nothing of use.
  void mark_front(std::vector<std::uint64_t>& bits) {
    const auto mark = [&](core::Slot s) { bits[s / 64] |= std::uint64_t(1) << s % 64; };
    const auto layers = layers_.used();
    for (const auto& layer : layers) std::for_each(layer->not_judged.begin(), layer->not_judged.end(), mark);
    for (std::size_t pixel = 0; pixel < pixels_ && !layers.empty(); ++pixel) {
      FrontLayer& first = *layers[0];
      for (const auto& other : layers.subspan(1))
        if (other->front_slot[pixel] != core::kNone)
          first.enter(pixel, other->nearest[pixel], other->front_slot[pixel]);
      if (first.front_slot[pixel] != core::kNone) mark(first.front_slot[pixel]);
    }
  }
  std::size_t memory_bytes() const { return layers_.memory_bytes(); }

 private:
  ObjectPool<FrontLayer> layers_;
  std::size_t pixels_ = 0;
};

}  // namespace sightline::culling
