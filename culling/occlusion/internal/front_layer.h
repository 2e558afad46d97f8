// Internal: which boxes the rays of a picture enter first.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "sightline/core/internal/scratch.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/occlusion/internal/lent.h"

namespace sightline::culling {

/// Of each pixel, the box that its ray enters first.
struct FrontLayer {
  void clear(std::size_t pixels) {
    nearest.assign(pixels, std::numeric_limits<float>::infinity());
    owner.assign(pixels, core::kNone);
    not_judged.clear();
  }
  void enter(std::size_t pixel, float distance, core::Slot slot) {
    float& known = nearest[pixel];
    if (!(distance < known || (distance == known && slot < owner[pixel]))) return;
    known = distance;
    owner[pixel] = slot;
  }
  std::size_t memory_bytes() const { return core::bytes_of(nearest, owner, not_judged); }

  std::vector<float> nearest;
  std::vector<core::Slot> owner;  // core::kNone: no box
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
        if (other->owner[pixel] != core::kNone) first.enter(pixel, other->nearest[pixel], other->owner[pixel]);
      if (first.owner[pixel] != core::kNone) mark(first.owner[pixel]);
    }
  }
  std::size_t memory_bytes() const { return layers_.memory_bytes(); }

 private:
  Lent<FrontLayer> layers_;
  std::size_t pixels_ = 0;
};

}  // namespace sightline::culling
