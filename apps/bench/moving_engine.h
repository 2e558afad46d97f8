// The engine that flies in sightline-bench motion: one that has the whole scene in memory, or one that reads pages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>

#include "sightline/apps/common/drawn_variant.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/paged/paged_engine.h"

namespace sightline::bench {

class MovingEngine {
 public:
  explicit MovingEngine(engine::Engine engine) : engine_(std::move(engine)) {}
  explicit MovingEngine(engine::PagedEngine engine) : engine_(std::move(engine)) {}
  /// Reads a scene cache page by page, within `memory` bytes beside what the process has now.
  static core::Expected<MovingEngine> paged(const std::string& file, std::size_t memory, engine::PagedConfig config);

  /// The parts of FrameReport and PagedReport that both have.
  struct Report {
    std::int64_t pending = 0;
    double coarseness = 1.0, earlier = 0.0;
  };
  /// Draws a frame and waits for it.
  core::Expected<Report> frame(const core::View& view);
  /// The image of the last frame.
  core::Expected<apps::DrawnImage> image(const core::View& view);
  /// Once a first frame is drawn, waits for what engines make in the background.
  void wait_for_preparations();

 private:
  std::variant<engine::Engine, engine::PagedEngine> engine_;
};

}  // namespace sightline::bench
