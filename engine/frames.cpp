// Functions of Engine that cull and draw frames.
#include <algorithm>
#include <variant>

#include "sightline/core/internal/clock.h"
#include "sightline/engine/internal/engine_state.h"
#include "sightline/gl/external_target.h"

namespace sightline::engine {
namespace {

/// A frame as its callers ask for it.
struct FrameTask {
  FrameInput input;
  double budget_began;  // when the time of a budget began to run, seconds on the steady clock
  std::optional<glm::vec2> blend_range = {};
  std::array<double, 2> rows{0.0, 1.0};  // as DrawRequest::rows

  const core::View& cull_view() const { return input.cull_view ? *input.cull_view : input.view; }
};

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
core::Expected<bool> cull_on_gpu(EngineState& s, const FrameTask& task, FrameReport& report) {
  const double begin = core::now_seconds();
  const auto done = s.backend->cull(task.cull_view(), task.input.view, *s.live.snapshot, report.frame);
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

/// Returns whether the GPU has culled: then the result stays there, and Engine::visible() is empty. `on_cpu`: the CPU
/// must cull; a hybrid does not learn from that.
core::Expected<bool> cull(EngineState& s, const FrameTask& task, bool on_cpu, FrameReport& report) {
  s.visible.clear();
  s.visible.generation = s.live.snapshot->generation();
  bool on_gpu = s.backend->ready() && s.live.plan.culler == CullerChoice::kGpu && !on_cpu;
  gather_late_reports(s);
  if (s.hybrid && on_cpu) {
    s.hybrid->paused();
    report.state = s.hybrid->controller().state();
  } else if (s.hybrid) {
    on_gpu = s.hybrid->next(report.frame_ms) == culling::CullPath::kGpu;
    report.state = s.hybrid->controller().state();
  }
  if (on_gpu)
    if (const auto done = cull_on_gpu(s, task, report); !done || *done) return done;
  cull_on_cpu(s, task.cull_view(), report);
  return false;
}

core::Expected<void> draw(EngineState& s, const FrameTask& task, bool on_gpu, bool shows_unseen, FrameReport& report) {
  if (!s.backend->ready()) return {};
  const double begin = core::now_seconds();
  if (on_gpu) {
    s.overlaid.clear();
    if (s.backend->has_overlays())
      std::visit([&](const auto& culler) { culler.cull(task.cull_view(), s.overlaid); }, *s.live.culler);
  }
  const Culled culled = s.culled(task.cull_view(), on_gpu ? s.overlaid : s.visible);
  const auto result = s.backend->draw({.view = task.input.view,
                                       .culled = culled,
                                       .on_gpu = on_gpu,
                                       .shows_unseen = shows_unseen,
                                       .frame = report.frame,
                                       .budget_began = task.budget_began,
                                       .target = task.input.target,
                                       .blend_range = task.blend_range,
                                       .rows = task.rows});
  report.drawn = s.config.draw && result;
  if (!result) {
    if (auto done = unless_lost(s, tl::unexpected(result.error())); !done) return done;
  }
  report.draw_ms = 1e3 * (core::now_seconds() - begin);
  if (!result) return {};
  report.wait_ms = result->wait_ms;
  if (!report.drawn || on_gpu) return {};
  report.sampled = result->counts.sampled;
  report.items_drawn = result->counts.items_drawn;
  report.triangles = result->counts.triangles;
  report.below_min_area = result->counts.below_min_area;
  report.pending = result->counts.pending;
  report.splats = result->counts.splats;
  return {};
}

core::Expected<FrameReport> run_frame(EngineState& s, const FrameTask& task) {
  const auto kept = s.keep_state();
  if (task.input.target)
    if (auto fits = fit_target(s, *task.input.target); !fits) return tl::unexpected(fits.error());
  auto ready = land(s);
  FrameReport report;
  report.frame = s.frames++;
  const double begin = core::now_seconds();
  if (s.last_frame_began >= 0.0) report.frame_ms = 1e3 * (begin - s.last_frame_began);
  s.last_frame_began = begin;
  s.frame_seconds = 1e-3 * report.frame_ms;
  look_after_context(s);
  if (ready) ready = make_gpu_follow(s);
  const auto failed = [&](const core::Error& error) {
    cull_on_cpu(s, task.cull_view(), report);  // Engine::visible() has the result all the same
    return tl::unexpected(error);
  };
  if (!ready) return failed(ready.error());
  const bool shows_unseen = s.shows_unseen(task.input.view, task.cull_view());
  const auto on_gpu = cull(s, task, shows_unseen, report);
  if (!on_gpu) return failed(on_gpu.error());
  if (auto done = draw(s, task, *on_gpu, shows_unseen, report); !done) return failed(done.error());
  if (s.hybrid && !shows_unseen) s.hybrid->measured(report);
  return report;
}

}  // namespace

core::Expected<FrameReport> Engine::frame(const core::View& view) {
  return frame(FrameInput{view});
}

core::Expected<FrameReport> Engine::frame(const core::View& view, const gl::ExternalTarget& target) {
  return frame(FrameInput{.view = view, .target = &target});
}

core::Expected<FrameReport> Engine::frame(const FrameInput& input) {
  return run_frame(*state_, {input, core::now_seconds()});
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
    auto report = run_frame(s, {{.view = views[i], .target = &targets[i]}, budget_began});
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
  FrameTask task{{*view}, core::now_seconds()};
  task.rows = {tile.y / tile.height, (tile.y + s.config.height) / tile.height};
  if (s.backend->blends()) {
    // Near surfaces weigh more than those behind them, by the depths of the whole image.
    std::visit([&](const auto& culler) { culler.cull(whole, s.overlaid); }, *s.live.culler);
    task.blend_range = s.backend->blend_range(whole, *s.live.snapshot, s.overlaid);
    task.budget_began = core::now_seconds();
  }
  return run_frame(s, task);
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
