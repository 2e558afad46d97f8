// The hybrid culler: asks the controller which path is to cull the next frame, and tells it what frames have cost, as
// far as and as soon as that is known. Internal to engine.
#pragma once

#include <array>
#include <cstdint>

#include "sightline/culling/controller.h"

namespace sightline::engine {

struct FrameReport;
struct LateReport;

class Hybrid {
 public:
  /// For so many items, from frame `first_frame` (FrameReport::frame) on. The GPU culler exists: the controller may
  /// choose it.
  Hybrid(const culling::ControllerConfig& config, std::size_t items, std::uint64_t first_frame);

  /// Begins a frame. `since_last_ms`: since the last one began; 0 for the first.
  culling::CullPath next(double since_last_ms);
  /// What the frame that has begun has cost the CPU. `walk`: of its hierarchy, as CpuCuller::describe tells it.
  void measured(const FrameReport& report, const culling::FrameSample& walk = {});
  /// An earlier frame is drawn, and kept the GPU busy so long; 0: not longer than it kept the CPU.
  void drawn(std::uint64_t frame, double gpu_ms);
  /// What the GPU found in an earlier frame.
  void measured(const LateReport& report);

  /// Time stood still since the last frame began.
  void paused() { controller_.paused(); }
  /// Another scene, of so many items, or other slots.
  void scene_changed(std::size_t items) { controller_.scene_changed(double(items)); }
  /// The GPU culler has failed or gone: the CPU's path until there is one again.
  void gpu_lost() { controller_.gpu_lost(); }
  void gpu_ready() {
    controller_.paused();  // what making it anew took is nobody's cost
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
  std::array<Pending, culling::kOldestSample> pending_;  // by the controller's frame
};

}  // namespace sightline::engine
