#include "sightline/apps/bench/moving_engine.h"

#include <chrono>
#include <thread>
#include <utility>

#include "sightline/core/internal/platform/memory.h"
#include "sightline/importers/slc/paged_scene.h"

namespace sightline::bench {

core::Expected<MovingEngine> MovingEngine::paged(const std::string& file, std::size_t memory,
                                                 engine::PagedConfig config) {
  config.memory_limit = memory + core::platform::process_memory();
  auto scene = importers::open_paged_scene(file);
  if (!scene) return tl::unexpected(scene.error());
  auto engine = engine::PagedEngine::create(std::move(*scene), config);
  if (!engine) return tl::unexpected(engine.error());
  return MovingEngine(std::move(*engine));
}

core::Expected<MovingEngine::Report> MovingEngine::frame(const core::View& view) {
  if (auto* const paged = std::get_if<engine::PagedEngine>(&engine_)) {
    const auto report = paged->frame(view);
    if (!report) return tl::unexpected(report.error());
    return Report{report->complete ? 0 : std::max<std::int64_t>(1, report->pending), report->coarseness,
                  report->earlier};
  }
  auto& whole = std::get<engine::Engine>(engine_);
  const auto report = whole.frame(view);
  if (!report) return tl::unexpected(report.error());
  if (!report->drawn) return core::fail("the GL context was lost");
  whole.finish();
  return Report{report->pending, report->coarseness, report->earlier};
}

core::Expected<apps::DrawnImage> MovingEngine::image(const core::View& view) {
  if (auto* const paged = std::get_if<engine::PagedEngine>(&engine_))
    return apps::DrawnImage{{paged->read_ids(), paged->read_depth()}, paged->read_colour()};
  return apps::read_image(std::get<engine::Engine>(engine_), view);
}

void MovingEngine::wait_for_preparations() {
#if SIGHTLINE_HAS_RAYTRACE
  if (const auto* const whole = std::get_if<engine::Engine>(&engine_))
    while (whole->preparing_picks()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
#endif
}

}  // namespace sightline::bench
