// Internal: which boxes the rays of a picture enter first.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "sightline/core/visible_set.h"

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
  std::vector<float> nearest;
  std::vector<core::Slot> owner;  // core::kNone: no box
  std::vector<core::Slot> not_judged;
};

/// One for each thread that enters boxes.
class FrontLayers {
 public:
  void begin(std::size_t pixels) {
    pixels_ = pixels;
    begun_ = 0;
    idle_.clear();
  }
  FrontLayer& take() {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      FrontLayer& layer = *idle_.back();
      idle_.pop_back();
      return layer;
    }
    if (begun_ == layers_.size()) layers_.push_back(std::make_unique<FrontLayer>());
    FrontLayer& layer = *layers_[begun_++];
    layer.clear(pixels_);
    return layer;
  }
  void give_back(FrontLayer& layer) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(&layer);
  }
  /// Sets the bits of the slots that belong to the front. Afterwards the layers hold nothing of use.
  void mark_front(std::vector<std::uint64_t>& bits) {
    const auto mark = [&](core::Slot s) { bits[s / 64] |= std::uint64_t(1) << s % 64; };
    const std::span layers = std::span(layers_).first(begun_);
    for (const auto& layer : layers) std::for_each(layer->not_judged.begin(), layer->not_judged.end(), mark);
    for (std::size_t pixel = 0; pixel < pixels_ && !layers.empty(); ++pixel) {
      FrontLayer& first = *layers[0];
      for (const auto& other : layers.subspan(1))
        if (other->owner[pixel] != core::kNone) first.enter(pixel, other->nearest[pixel], other->owner[pixel]);
      if (first.owner[pixel] != core::kNone) mark(first.owner[pixel]);
    }
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<FrontLayer>> layers_;  // the first begun_ of them belong to this set
  std::vector<FrontLayer*> idle_;
  std::size_t begun_ = 0, pixels_ = 0;
};

}  // namespace sightline::culling
