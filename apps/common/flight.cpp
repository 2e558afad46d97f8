#include "sightline/apps/common/flight.h"

#include <algorithm>

namespace sightline::apps {

std::vector<double> Flight::collect(double (*pick)(const engine::FrameReport&)) const {
  std::vector<double> values;
  for (const FlownFrame& frame : frames)
    if (const double value = pick(frame.report); value >= 0.0) values.push_back(value);
  return values;
}

std::size_t Flight::on_gpu() const {
  return std::size_t(std::count_if(frames.begin(), frames.end(),
                                   [](const FlownFrame& f) { return f.report.culler == engine::CullerChoice::kGpu; }));
}

std::size_t Flight::switches() const {
  std::size_t count = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) count += frames[i].report.culler != frames[i - 1].report.culler;
  return count;
}

void take_late_reports(engine::Engine& engine, Flight& flight) {
  while (const auto late = engine.take_late_report()) {
    FlownFrame& frame = flight.frames[std::size_t(late->frame)];
    frame.report.visible = late->visible;
    if (frame.report.drawn) frame.report.items_drawn = late->items_drawn;
    frame.gpu_cull_ms = late->gpu_cull_ms;
  }
}

core::Expected<Flight> fly(engine::Engine& engine, const core::CameraPath& path, const FlightOptions& options,
                           const std::function<core::Expected<void>(Flight&)>& after_frame) {
  Flight flight;
  for (int i = 0; i < options.frames; ++i) {
    const double time = path.time_of(i, options.frames);
    auto view = path.view(time, options.aspect);
    if (!view) return tl::unexpected(view.error());
    auto report = engine.frame(*view);
    if (!report) return tl::unexpected(report.error());
    if (options.draws && !report->drawn) return core::fail("frame " + std::to_string(i) + ": the GL context was lost");
    flight.frames.push_back({time, *report});
    take_late_reports(engine, flight);
    if (!after_frame) continue;
    if (auto done = after_frame(flight); !done) return tl::unexpected(done.error());
  }
  engine.finish();
  take_late_reports(engine, flight);
  if (std::string renderer = engine.renderer(); !renderer.empty()) flight.renderer = std::move(renderer);
  for (const std::string& error : engine.take_gl_errors()) return core::fail("GL: " + error);
  return flight;
}

}  // namespace sightline::apps
