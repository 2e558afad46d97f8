// Functions of Engine that cull and draw frames.
#include <algorithm>
#include <variant>

#include "sightline/core/internal/clock.h"
#include "sightline/engine/internal/engine_state.h"
#include "sightline/engine/internal/settings.h"
#include "sightline/gl/external_target.h"

namespace sightline::engine {
namespace {

core::Expected<void> fit_target(EngineState& s, const gl::ExternalTarget& target) {
  if (!s.config.draw || !s.config.context.application)
    return core::fail(
        "engine: an external target needs EngineConfig::draw and the application's EngineConfig::context.application");
  if (target.width == s.config.width && target.height == s.config.height) return {};
  return resize(s, target.width, target.height);
}

void cull_on_cpu(EngineState& s, const core::View& view, FrameReport& report) {
  const double begin = core::now_seconds();
  std::visit([&](const auto& culler) { culler.cull(view, s.visible); }, *s.live.culler);
  report.cull_ms = 1e3 * (core::now_seconds() - begin);
  report.culler =
      std::holds_alternative<culling::CpuCuller>(*s.live.culler) ? CullerChoice::kCpu : CullerChoice::kLinear;
  report.visible = std::int64_t(s.live.snapshot->count(s.visible));
  report.tested = std::int64_t(s.visible.counters.nodes_tested + s.visible.counters.boxes_tested);
}

/// Returns false where the CPU must cull instead.
core::Expected<bool> cull_on_gpu(EngineState& s, const Frame& frame, FrameReport& report) {
  const double begin = core::now_seconds();
  const auto done = s.backend->cull(frame);
  if (done) {
    report.culler = CullerChoice::kGpu;
    report.cull_ms = 1e3 * (core::now_seconds() - begin);
    report.visible = report.tested = -1;
    return true;
  }
  if (s.hybrid)
    s.hybrid->gpu_lost();
  else if (auto error = unless_lost(s, done); !error)
    return tl::unexpected(error.error());
  return false;
}

void gather_late_reports(EngineState& s) {
  constexpr std::size_t kMost = 64;
  if (s.hybrid)
    while (const auto drawn = s.backend->take_drawn()) s.hybrid->drawn(drawn->frame, drawn->gpu_ms);
  while (const auto report = s.backend->take_late_report()) {
    s.late.push_back(*report);
    if (s.hybrid) s.hybrid->measured(s.late.back());
    if (s.late.size() > kMost) s.late.pop_front();
  }
}

/// Returns whether the GPU has culled: then the result stays there, and Engine::visible() is empty. The CPU
/// must cull where items are shown that are not seen; a hybrid does not learn from that.
core::Expected<bool> cull(EngineState& s, const Frame& frame, FrameReport& report) {
  s.visible.clear();
  s.visible.generation = s.live.snapshot->generation();
  bool on_gpu =
      s.backend->ready() && !s.backend->traces() && s.live.plan.culler == CullerChoice::kGpu && !frame.shows_unseen;
  gather_late_reports(s);
  if (s.hybrid && frame.shows_unseen) {
    s.hybrid->paused();
    report.state = s.hybrid->controller().state();
  } else if (s.hybrid) {
    on_gpu = s.hybrid->next(report.frame_ms) == culling::CullPath::kGpu;
    report.state = s.hybrid->controller().state();
  }
  if (on_gpu)
    if (const auto done = cull_on_gpu(s, frame, report); !done || *done) return done;
  cull_on_cpu(s, frame.cull_view, report);
  return false;
}

/// Ignores a failure that comes from losing the context.
core::Expected<void> note_drawn(EngineState& s, const core::Expected<DrawResult>& result, bool on_gpu,
                                FrameReport& report) {
  report.drawn = s.config.draw && result;
  if (!result) return unless_lost(s, tl::unexpected(result.error()));
  report.wait_ms = result->wait_ms;
  if (!report.drawn || on_gpu) return {};
  report.sampled = result->counts.sampled;
  report.items_drawn = result->counts.items_drawn;
  report.triangles = result->counts.triangles;
  report.below_min_area = result->counts.below_min_area;
  report.pending = result->counts.pending;
  report.splats = result->counts.splats;
  report.coarseness = result->counts.coarseness;
  report.earlier = result->counts.earlier;
  return {};
}

/// Begins the report of a frame, for which the engine brings in what has become ready.
core::Expected<void> begin_frame(EngineState& s, FrameReport& report) {
  auto ready = land(s);
  report.frame = s.frames++;
  const double begin = core::now_seconds();
  if (s.last_frame_began >= 0.0) report.frame_ms = 1e3 * (begin - s.last_frame_began);
  s.last_frame_began = begin;
  s.frame_seconds = 1e-3 * report.frame_ms;
  look_after_context(s);
  return ready ? make_gpu_follow(s) : ready;
}

/// The tracer for images by rays, which is made now unless that goes on in the background until a context comes, and
/// for moving images of a budget, which is made in the background; null where there is none yet, or none is needed.
core::Expected<const raytrace::Tracer*> tracer_of_frame([[maybe_unused]] EngineState& s) {
#if SIGHTLINE_HAS_RAYTRACE
  if (s.backend->traces()) {
    if (traces_until_context(s.config) && !s.new_tracer.ready()) return nullptr;
    s.new_tracer.finish(s.live);
    return make_tracer(s.live).map([&] { return s.live.tracer.get(); });
  }
  if (s.config.losses.budget_ms <= 0.0 || !s.backend->software() || !s.new_tracer.for_motion) return nullptr;
  if (!s.live.tracer && s.new_tracer.ready()) {
    s.new_tracer.finish(s.live);
    s.new_tracer.begin(s.live);
  }
  return s.live.tracer.get();
#else
  return nullptr;
#endif
}

/// What the caller of a frame may know besides its views.
struct FramePart {
  double budget_began = core::now_seconds();  // when the time of a budget began to run, on the steady clock
  std::optional<glm::vec2> blend_range = {};  // as Frame has them
  std::array<double, 2> rows{0.0, 1.0};
};

core::Expected<FrameReport> run_frame(EngineState& s, const FrameInput& input, const FramePart& part = {}) {
  const auto kept = s.keep_state();
  if (input.target)
    if (auto fits = fit_target(s, *input.target); !fits) return tl::unexpected(fits.error());
  FrameReport report;
  const core::View& cull_view = input.cull_view ? *input.cull_view : input.view;
  const auto failed = [&](const core::Error& error) {
    cull_on_cpu(s, cull_view, report);  // Engine::visible() has the result all the same
    return tl::unexpected(error);
  };
  if (auto ready = begin_frame(s, report); !ready) return failed(ready.error());
  Frame frame = s.frame(input.view, cull_view);
  frame.number = report.frame;
  frame.budget_began = part.budget_began;
  frame.overlaid = s.backend->has_overlays();
  frame.shows_unseen = s.shows_unseen(input.view, cull_view);
  frame.target = input.target;
  frame.at_rest = input.at_rest;
  frame.blend_range = part.blend_range;
  frame.rows = part.rows;
  const auto tracer = tracer_of_frame(s);
  if (!tracer) return failed(tracer.error());
  frame.tracer = *tracer;
  const auto on_gpu = cull(s, frame, report);
  if (!on_gpu) return failed(on_gpu.error());
  if (s.backend->ready() && (frame.tracer || !s.backend->traces())) {
    const double begin = core::now_seconds();
    if (*on_gpu) {
      s.overlaid.clear();
      if (frame.overlaid) std::visit([&](const auto& culler) { culler.cull(cull_view, s.overlaid); }, *s.live.culler);
    }
    const auto drawn = s.backend->draw(frame, *on_gpu ? s.overlaid : s.visible, *on_gpu);
    if (auto done = note_drawn(s, drawn, *on_gpu, report); !done) return failed(done.error());
    report.draw_ms = 1e3 * (core::now_seconds() - begin);
  }
  if (s.hybrid && !frame.shows_unseen) s.hybrid->measured(report);
  return report;
}

}  // namespace

core::Expected<FrameReport> Engine::frame(const core::View& view) {
  return run_frame(*state_, {view});
}

core::Expected<FrameReport> Engine::frame(const core::View& view, const gl::ExternalTarget& target) {
  return run_frame(*state_, {.view = view, .target = &target});
}

core::Expected<FrameReport> Engine::frame(const FrameInput& input) {
  return run_frame(*state_, input);
}

core::Expected<std::vector<FrameReport>> Engine::frame(std::span<const core::View> views,
                                                       std::span<const gl::ExternalTarget> targets) {
  EngineState& s = *state_;
  if (views.size() != targets.size())
    return core::fail("engine: expected as many targets as views, found " + std::to_string(targets.size()) + " for " +
                      std::to_string(views.size()));
  const auto kept = s.keep_state();
  const std::uint32_t before = s.image;
  const double began = core::now_seconds();
  const double share = 1e-3 * s.config.losses.budget_ms / double(std::max<std::size_t>(views.size(), 1));
  std::vector<FrameReport> reports;
  core::Expected<void> done;
  for (std::size_t i = 0; done && i < views.size(); ++i) {
    done = switch_image(s, std::uint32_t(i));
    if (!done) break;
    // The budget of the last view ends with that of all, and each view may use what those before it have left.
    const double budget_began = began - share * double(views.size() - 1 - i);
    auto report = run_frame(s, {.view = views[i], .target = &targets[i]}, {budget_began});
    if (report)
      reports.push_back(*report);
    else
      done = tl::unexpected(report.error());
  }
  if (auto back = switch_image(s, before); done) done = back;
  if (!done) return tl::unexpected(done.error());
  return reports;
}

core::Expected<FrameReport> Engine::frame_tile(const core::View& whole, const ImageTile& tile) {
  EngineState& s = *state_;
  const auto view = culling::rectangle_view(whole, tile.width, tile.height, tile.x, tile.y, tile.x + s.config.width,
                                            tile.y + s.config.height);
  if (!view) return tl::unexpected(view.error());
  const auto kept = s.keep_state();
  if (auto landed = land(s); !landed) return tl::unexpected(landed.error());
  FramePart part{.rows = {tile.y / tile.height, (tile.y + s.config.height) / tile.height}};
  if (s.backend->blends()) {
    // Near surfaces weigh more than those behind them, by the depths of the whole image.
    std::visit([&](const auto& culler) { culler.cull(whole, s.overlaid); }, *s.live.culler);
    part.blend_range = s.backend->blend_range(whole, *s.live.snapshot, s.overlaid);
    part.budget_began = core::now_seconds();
  }
  return run_frame(s, {*view}, part);
}

std::optional<LateReport> Engine::take_late_report() {
  EngineState& s = *state_;
  if (s.live.plan.gpu_culls()) {
    const auto kept = s.keep_state();
    gather_late_reports(s);
  }
  if (s.late.empty()) return std::nullopt;
  const LateReport oldest = s.late.front();
  s.late.pop_front();
  return oldest;
}

}  // namespace sightline::engine
