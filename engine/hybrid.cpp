#include "sightline/engine/hybrid.h"

#include "sightline/engine/engine.h"

namespace sightline::engine {

using culling::Path;

Hybrid::Hybrid(const culling::ControllerConfig& config, std::size_t items, std::uint64_t first_frame)
    : controller_(config), first_frame_(first_frame) {
  scene_changed(items);
  controller_.gpu_ready();
}

Path Hybrid::next(double since_last_ms) {
  const std::uint64_t frame = controller_.frames();
  if (frame > 0) {
    Pending& last = pending(frame - 1);
    last.sample.frame_ms = since_last_ms;
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

void Hybrid::measured(const FrameReport& report) {
  Pending& p = pending(controller_.frames() - 1);
  if (p.sample.path == Path::kGpu) return;  // its CPU time is that of submitting
  p.sample.cull_ms = report.cull_ms;
  p.sample.visible = double(report.visible);
  p.sample.tested = double(report.tested);
  p.late_known = true;
}

void Hybrid::measured(const LateReport& report) {
  if (report.frame < first_frame_) return;
  const std::uint64_t frame = report.frame - first_frame_;
  Pending& p = pending(frame);
  if (p.sample.frame != frame || p.sample.path != Path::kGpu || p.fed) return;
  p.sample.visible = double(report.visible);
  if (report.gpu_cull_ms >= 0.0) p.sample.cull_ms = report.gpu_cull_ms;
  p.late_known = true;
  feed_when_complete(p);
}

void Hybrid::feed_when_complete(Pending& p) {
  if (p.fed || !p.interval_known || !p.late_known) return;
  p.fed = true;
  controller_.feed(p.sample);
}

}  // namespace sightline::engine
