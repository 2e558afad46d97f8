// Figures of the last images, for plots.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/engine/engine.h"

namespace sightline::apps {

struct FrameFigures {
  double cull_ms, image_ms;  ///< of an image: culling and drawing
  bool on_gpu;               ///< who culled
  std::int64_t visible,
      items_drawn;  ///< items in the view volume, as last known; items drawn, -1 where the GPU alone knows
};

class FrameHistory {
 public:
  static constexpr std::size_t kMost = 240;

  void add(const engine::FrameReport& report, std::int64_t visible) {
    frames_.push_back({report.cull_ms, report.cull_ms + report.draw_ms, report.culler == engine::CullerChoice::kGpu,
                       visible, report.items_drawn});
    if (frames_.size() > kMost) frames_.erase(frames_.begin());
  }
  const std::vector<FrameFigures>& frames() const { return frames_; }  ///< the last one last

 private:
  std::vector<FrameFigures> frames_;
};

}  // namespace sightline::apps
