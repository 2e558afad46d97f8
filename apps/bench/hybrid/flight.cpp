#include "sightline/apps/bench/hybrid/flight.h"

#include <algorithm>
#include <numeric>
#include <string_view>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/common/need.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"

namespace sightline::bench {
namespace {

using apps::need;

double sum(const std::vector<HybridFrame>& frames, bool rendering) {
  return std::accumulate(frames.begin(), frames.end(), 0.0,
                         [=](double s, const HybridFrame& f) { return s + f.cost(rendering); });
}

engine::Engine make_engine(core::Scene& scene, const HybridMode& mode, const FlightConfig& config,
                           gl::Context& context) {
  engine::EngineConfig engine_config;
  engine_config.culling.culler = mode.culler;
  engine_config.draw = config.rendering;
  engine_config.width = config.width;
  engine_config.height = config.height;
  engine_config.context.application = &context;
  engine_config.context.gl_state = engine::GlState::kLeave;  // nobody else draws there
  engine_config.culling.gpu_variant = config.gpu;
  engine_config.culling.occlusion = config.occlusion;
  return need(engine::Engine::create(scene, engine_config));
}

}  // namespace

Pilot::Pilot(core::Scene& scene, const HybridMode& mode, const FlightConfig& config, gl::Context& context)
    : engine_(make_engine(scene, mode, config, context)) {}

void Pilot::frame(const core::View& view, bool counts) {
  const double thread = thread_milliseconds();
  const engine::FrameReport report = need(engine_.frame(view));
  const double spent = thread_milliseconds() - thread;
  if (!place_.empty() && place_.back() != core::kNone) frames_[place_.back()].frame_ms = report.frame_ms;
  place_.push_back(counts ? frames_.size() : core::kNone);
  if (counts)
    frames_.push_back({report.cull_ms, -1.0, 0.0, spent, report.visible, report.culler == engine::CullerChoice::kGpu});
  take_late();
}

void Pilot::take_late() {
  while (const auto late = engine_.take_late_report()) {
    const std::size_t place = place_[std::size_t(late->frame)];
    if (place == core::kNone) continue;
    frames_[place].visible = late->visible;
    frames_[place].gpu_cull_ms = late->gpu_cull_ms;
  }
}

void Pilot::fly(std::span<const core::View> views, int lead_in) {
  engine_.paused();
  for (int i = 0; i < lead_in; ++i) frame(views.front(), false);
  for (const core::View& view : views) frame(view, true);
  frame(views.back(), false);
  engine_.finish();
  take_late();
}

HybridFlight Pilot::land() && {
  HybridFlight flight{std::move(frames_), 0, 0, {}, std::string(name_of(engine_.plan().culler))};
  if (engine::EngineParts::drawing(engine_) && engine::EngineParts::drawing(engine_)->gpu_culler())
    flight.gpu_variant = culling::name_of(engine::EngineParts::drawing(engine_)->gpu_culler()->variant());
  if (const culling::Controller* controller = engine_.controller()) {
    flight.switches = controller->switches();
    flight.probes = controller->probes();
  }
  return flight;
}

std::vector<double> HybridRun::costs(std::size_t mode) const {
  std::vector<double> medians;
  medians.reserve(frames());
  for (std::size_t i = 0; i < frames(); ++i) {
    std::vector<double> passes;
    for (const HybridFlight& flight : flights[mode]) passes.push_back(flight.frames[i].cost(rendering));
    medians.push_back(apps::median(std::move(passes)));
  }
  return medians;
}

std::size_t HybridRun::better_path() const {
  const auto total = [&](std::size_t mode) {
    const std::vector<double> all = costs(mode);
    return std::accumulate(all.begin(), all.end(), 0.0);
  };
  return total(1) < total(0) ? 1 : 0;
}

double HybridRun::ratio(std::size_t mode, std::size_t other) const {
  std::vector<double> ratios;
  for (std::size_t pass = 0; pass < flights[mode].size(); ++pass)
    ratios.push_back(sum(flights[mode][pass].frames, rendering) / sum(flights[other][pass].frames, rendering));
  return apps::median(std::move(ratios));
}

HybridRun fly_in_turns(core::Scene& scene, const FlightConfig& config, gl::Context& context,
                       std::span<const core::View> views, int passes, const std::function<void(int)>& progress) {
  constexpr int kInFlight = 2;
  HybridRun run;
  run.items = scene.item_count();
  run.rendering = config.rendering;
  run.flights.resize(kModes);
  for (int pass = 0; pass < passes; ++pass) {
    progress(pass);
    std::vector<Pilot> pilots;
    for (const HybridMode& mode : kHybridModes) pilots.emplace_back(scene, mode, config, context);
    auto turn = std::size_t(pass);
    for (std::size_t first = 0; first < views.size(); first += std::size_t(config.block), ++turn) {
      const auto block = views.subspan(first, std::min(std::size_t(config.block), views.size() - first));
      for (std::size_t i = 0; i < kModes; ++i)
        pilots[(i + turn) % kModes].fly(block, first == 0 ? config.warm_up : kInFlight);
    }
    for (std::size_t mode = 0; mode < kModes; ++mode) run.flights[mode].push_back(std::move(pilots[mode]).land());
  }
  for (const std::string& error : context.take_errors()) apps::fail("GL: " + error);
  return run;
}

}  // namespace sightline::bench
