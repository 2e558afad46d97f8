#include "sightline/engine/internal/hybrid.h"

#include <algorithm>

#include "sightline/engine/engine.h"

namespace sightline::engine {

using culling::CullPath;

Hybrid::Hybrid(const culling::ControllerConfig& config, std::size_t items, std::uint64_t first_frame)
    : controller_(config), first_frame_(first_frame) {
  scene_changed(items);
  controller_.gpu_ready();
}

CullPath Hybrid::next(double since_last_ms) {
  const std::uint64_t frame = controller_.frames();
  if (frame > 0) {
    Pending& last = pending(frame - 1);
    last.interval_ms = since_last_ms;
    last.interval_known = true;
    feed_when_complete(last);
  }
  Pending& p = pending(frame);
  p = {};
  p.sample.frame = frame;
  p.sample.path = controller_.next();
  p.fed = false;
  return p.sample.path;
}

/// Finds a frame that still waits for measurements; null if there is none.
Hybrid::Pending* Hybrid::find(std::uint64_t report_frame) {
  const std::uint64_t frame = report_frame - first_frame_;  // earlier frames wrap beyond all pending ones
  Pending& p = pending(frame);
  return p.sample.frame == frame && !p.fed ? &p : nullptr;
}

void Hybrid::measured(const FrameReport& report) {
  Pending& p = pending(controller_.frames() - 1);
  p.wait_ms = report.wait_ms;
  p.drawn = !report.drawn;                      // then there is no drawing to wait for
  if (p.sample.path == CullPath::kGpu) return;  // its CPU time is that of the submission
  p.sample.cull_ms = report.cull_ms;
  p.sample.visible = double(report.visible);
  p.late_known = true;
}

void Hybrid::measured(const LateReport& report) {
  Pending* p = find(report.frame);
  if (!p || p->sample.path != CullPath::kGpu) return;
  p->sample.visible = double(report.visible);
  if (report.gpu_cull_ms >= 0.0) p->sample.cull_ms = report.gpu_cull_ms;
  p->late_known = true;
  feed_when_complete(*p);
}

void Hybrid::drawn(std::uint64_t frame, double gpu_ms) {
  Pending* p = find(frame);
  if (!p) return;
  p->gpu_ms = gpu_ms;
  p->drawn = true;
  feed_when_complete(*p);
}

/// The interval between two frames includes the CPU's time for the first of them, and its wait for the frame two frames
/// before. If the whole interval counted, one path would pay for a frame of the other. So each frame is charged with
/// the interval without the wait, or with the GPU's time if that is longer.
void Hybrid::feed_when_complete(Pending& p) {
  if (p.fed || !p.interval_known || !p.late_known || !p.drawn) return;
  p.fed = true;
  p.sample.frame_ms = std::max(p.interval_ms - p.wait_ms, p.gpu_ms);
  controller_.feed(p.sample);
}

}  // namespace sightline::engine
