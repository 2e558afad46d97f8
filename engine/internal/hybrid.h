// The hybrid culler. Asks the controller which path culls the next frame, and tells it what frames cost as soon as that
// is known. Internal to engine.
#pragma once

#include <array>
#include <cstdint>

#include "sightline/culling/hybrid/controller.h"

namespace sightline::engine {

struct FrameReport;
struct LateReport;

class Hybrid {
 public:
  /// `items`: number of items. `first_frame`: FrameReport::frame of the first frame. The GPU culler must exist: the
  /// controller may choose it.
  Hybrid(const culling::ControllerConfig& config, std::size_t items, std::uint64_t first_frame);

  /// Begins a frame and returns its path. `since_last_ms`: time since the last frame began; 0 for the first.
  culling::CullPath next(double since_last_ms);
  /// Reports the CPU cost of the frame that has begun.
  void measured(const FrameReport& report);
  /// Reports that an earlier frame is drawn. `gpu_ms`: how long it kept the GPU busy; 0: not longer than the CPU.
  void drawn(std::uint64_t frame, double gpu_ms);
  /// Reports the GPU's result of an earlier frame.
  void measured(const LateReport& report);

  /// The application drew nothing for a while since the last frame began.
  void paused() { controller_.paused(); }
  /// The scene has changed and holds `items` items now, or the slots have changed.
  void scene_changed(std::size_t items) { controller_.scene_changed(double(items)); }
  /// The GPU culler has failed or is gone: the CPU's path culls until there is one again.
  void gpu_lost() { controller_.gpu_lost(); }
  void gpu_ready() {
    controller_.paused();  // the time to make the culler anew is charged to no path
    controller_.gpu_ready();
  }

  const culling::Controller& controller() const { return controller_; }

 private:
  struct Pending {
    culling::FrameSample sample;
    double interval_ms = 0.0, wait_ms = 0.0, gpu_ms = 0.0;
    bool interval_known = false, late_known = false, drawn = false, fed = true;
  };
  Pending* find(std::uint64_t report_frame);
  Pending& pending(std::uint64_t frame) { return pending_[frame % pending_.size()]; }
  void feed_when_complete(Pending& p);

  culling::Controller controller_;
  std::uint64_t first_frame_;
  std::array<Pending, culling::kOldestSample> pending_;  // frame f of the controller at f modulo the size
};

}  // namespace sightline::engine
