// Flies a camera path with an engine and keeps what each frame reports.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sightline/core/camera_path.h"
#include "sightline/engine/engine.h"

namespace sightline::apps {

struct FlownFrame {
  double time;  ///< seconds, along the path
  engine::FrameReport report;
  double gpu_cull_ms = -1.0;
};

struct Flight {
  std::vector<FlownFrame> frames;
  std::string renderer = "none";

  /// A value of each frame, but negative ones, which were not measured.
  std::vector<double> collect(double (*pick)(const engine::FrameReport&)) const;
  template <auto kField>
  std::vector<double> of() const {
    return collect([](const engine::FrameReport& report) { return double(report.*kField); });
  }
  std::vector<double> visible() const { return of<&engine::FrameReport::visible>(); }
  std::vector<double> sampled() const { return of<&engine::FrameReport::sampled>(); }
  std::vector<double> items_drawn() const { return of<&engine::FrameReport::items_drawn>(); }
  std::size_t on_gpu() const;  ///< frames
  /// Number of frames culled by another path than the frame before.
  std::size_t switches() const;
};

struct FlightOptions {
  int frames;
  double aspect;
  bool draws;  ///< a frame that is not drawn is then an error
};

/// Flies `options.frames` evenly spaced frames. Calls `after_frame`, if there is one, with the flight so far. Waits in
/// the end until all is drawn.
core::Expected<Flight> fly(engine::Engine& engine, const core::CameraPath& path, const FlightOptions& options,
                           const std::function<core::Expected<void>(Flight&)>& after_frame = {});

/// Enters the GPU's times and counts, which arrive some frames late.
void take_late_reports(engine::Engine& engine, Flight& flight);

}  // namespace sightline::apps
