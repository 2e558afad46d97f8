#include "sightline/engine/engine.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "sightline/core/internal/deadline.h"
#include "sightline/engine/internal/clock.h"
#include "sightline/engine/internal/engine_impl.h"
#include "sightline/engine/internal/picking.h"

namespace sightline::engine {
namespace {

constexpr double kFewSlots = 256.0;           // fewer are not worth a thread
constexpr std::size_t kCommittedPiece = 512;  // edits at a time, where a commit goes on later
constexpr double kShareOfSnapshot = 0.75;     // of the time that making an engine takes
// Frames and commits work so long for a new order that is to land: seconds, and a share of what the last frame took.
constexpr double kLeastLanding = 0.001, kMostLanding = 0.008, kLandingShare = 0.25;
// Measured on llvmpipe: 1.15 to 1.2 times the frame of the CPU's path (docs/hybrid-culling.md).
constexpr double kSoftwareGpuExcess = 0.1;

/// `picks`: the application has picked.
PlanRequest plan_request(const EngineConfig& config, bool picks) {
  return {config.culler,
          config.draw,
          config.ids,
          config.occlusion,
          config.contribution > 0.0f,
          config.budget_ms > 0.0,
          config.relief.any(),
          config.hatching.any(),
          picks,
          config.part};
}

/// Adds slots below `size`, so that each is there once.
void add_slots(std::span<const core::Slot> slots, std::size_t size, std::vector<core::Slot>& touched) {
  for (const core::Slot slot : slots)
    if (slot < size) touched.push_back(slot);
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
}

/// Takes some edits out of a delta, of which removals come first.
core::SceneDelta first_of(core::SceneDelta& delta) {
  core::SceneDelta piece;
  piece.materials = std::exchange(delta.materials, {});
  std::size_t room = kCommittedPiece;
  for (const auto list : {&core::SceneDelta::removed, &core::SceneDelta::changed, &core::SceneDelta::inserted}) {
    std::vector<core::ItemId>&from = delta.*list, &to = piece.*list;
    const auto count = std::ptrdiff_t(std::min(room, from.size()));
    to.assign(from.end() - count, from.end());
    from.erase(from.end() - count, from.end());
    room -= std::size_t(count);
  }
  return piece;
}

core::Expected<void> check(const EngineConfig& config) {
  if (!(config.contribution >= 0.0f)) return core::fail("engine: contribution must be 0 or more pixels");
  if (config.context_later && config.context)
    return core::fail("engine: context_later means that there is no context yet, and there is one");
  if (!(config.budget_ms >= 0.0)) return core::fail("engine: budget_ms must be 0 or more milliseconds");
  for (const float strength : {config.relief.shading, config.relief.lines})
    if (!(strength >= 0.0f && strength <= 1.0f))
      return core::fail("engine: shading and lines of relief must be between 0 and 1");
  if (!(config.hatching.strength >= 0.0f && config.hatching.strength <= 1.0f))
    return core::fail("engine: strength of hatching must be between 0 and 1");
  if (!(config.hatching.spacing >= 2.0f) || !std::isfinite(config.hatching.spacing))
    return core::fail("engine: spacing of hatching must be 2 or more pixels");
  if (config.part.count < 1 || config.part.index < 0 || config.part.index >= config.part.count)
    return core::fail("engine: part must have an index from 0 on and below its count");
  if (config.culler == CullerChoice::kGpu && plan_request(config, false).needs_cpu())
    return core::fail("engine: contribution and budget_ms need a culler on the CPU, and culler is gpu");
  return {};
}

/// Whether what a hybrid has learnt with one holds with the other, as far as settings go.
bool cost_alike(const EngineConfig& a, const EngineConfig& b) {
  return a.controller == b.controller && a.sample_test == b.sample_test && a.occlusion == b.occlusion;
}

/// The name of a setting in which they differ, though it needs a new engine; null where there is none.
const char* fixed_setting_that_differs(const EngineConfig& a, const EngineConfig& b) {
  if (a.draw != b.draw) return "draw";
  if (a.width != b.width || a.height != b.height) return "size (see resize())";
  if (a.ids != b.ids) return "ids";
  if (a.transparency != b.transparency) return "transparency";
  if (a.samples != b.samples) return "samples";
  if (a.part.index != b.part.index || a.part.count != b.part.count) return "part";
  if (a.gl_debug != b.gl_debug) return "gl_debug";
  if (a.context != b.context || a.context_platform != b.context_platform) return "context (see use_context())";
  if (a.context_later != b.context_later) return "context_later";
  if (a.gl_state != b.gl_state) return "gl_state";
  if (a.program_cache != b.program_cache) return "program_cache";
  if (a.rebuild_share != b.rebuild_share) return "rebuild_share";
  if (a.gpu_culler.variant != b.gpu_culler.variant) return "gpu_culler";
  return nullptr;
}

}  // namespace

// --- public interface ------------------------------------------------------------------------------------------------

core::Expected<Engine> Engine::create(core::Scene& scene, const EngineConfig& config, const Progress& progress) {
  if (auto good = check(config); !good) return tl::unexpected(good.error());
  if (auto delta = scene.commit(); !delta) return tl::unexpected(delta.error());
  auto impl = std::make_unique<Impl>(scene, config);
  if (auto done = impl->build(progress); !done) return tl::unexpected(done.error());
  if (progress) progress(1.0);
  return Engine(std::move(impl));
}

Engine::Engine(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Engine::Engine(Engine&&) noexcept = default;
Engine& Engine::operator=(Engine&&) noexcept = default;
Engine::~Engine() = default;

core::Expected<FrameReport> Engine::frame(const core::View& view) {
  return frame(view, view);
}
core::Expected<FrameReport> Engine::frame(const core::View& view, const core::View& cull_view) {
  return impl_->frame(view, cull_view, nullptr);
}
core::Expected<FrameReport> Engine::frame(const core::View& view, const core::ExternalTarget& target) {
  return impl_->frame(view, view, &target);
}
core::Expected<std::vector<FrameReport>> Engine::frame(std::span<const core::View> views,
                                                       std::span<const core::ExternalTarget> targets) {
  return impl_->frame(views, targets);
}
core::Expected<void> Engine::use_picture(std::uint32_t number) {
  return impl_->use_picture(number);
}
core::Expected<void> Engine::forget_picture(std::uint32_t number) {
  return impl_->forget_picture(number);
}
core::Expected<FrameReport> Engine::frame_part(const core::View& whole, const PicturePart& part) {
  return impl_->frame_part(whole, part);
}
std::optional<LateReport> Engine::take_late_report() {
  return impl_->take_late_report();
}
core::Expected<void> Engine::commit() {
  return impl_->commit(core::kNoDeadline).map([](bool) {});
}
core::Expected<bool> Engine::commit(double seconds) {
  return impl_->commit(core::deadline_in(seconds));
}
core::Expected<void> Engine::rebuild() {
  return impl_->rebuild();
}
bool Engine::rebuilding() const {
  return impl_->rebuilding();
}
const EngineConfig& Engine::config() const {
  return impl_->config();
}
core::Expected<void> Engine::configure(const EngineConfig& config) {
  return impl_->configure(config);
}
core::Expected<void> Engine::set_culler(CullerChoice choice) {
  EngineConfig changed = impl_->config();
  changed.culler = choice;
  return impl_->configure(changed);
}
core::Expected<void> Engine::resize(int width, int height) {
  return impl_->resize(width, height);
}
core::Expected<void> Engine::set_override(std::span<const core::ItemId> items, const ItemStyle& style) {
  return impl_->set_override(items, style);
}
core::Expected<void> Engine::clear_override(std::span<const core::ItemId> items) {
  return impl_->clear_override(items);
}
core::Expected<void> Engine::clear_overrides() {
  return impl_->clear_overrides();
}
core::Expected<void> Engine::hide(std::span<const core::ItemId> items) {
  return impl_->hide(items);
}
core::Expected<void> Engine::show(std::span<const core::ItemId> items) {
  return impl_->show(items);
}
core::Expected<void> Engine::isolate(std::span<const core::NodeId> nodes) {
  return impl_->isolate(nodes);
}
core::Expected<void> Engine::show_all() {
  return impl_->show_all();
}
std::optional<ItemStyle> Engine::override_of(core::ItemId item) const {
  return impl_->overrides().style(item);
}
std::vector<core::ItemId> Engine::overridden_items() const {
  return impl_->overrides().styled_items();
}
bool Engine::is_hidden(core::ItemId item) const {
  return impl_->overrides().is_hidden(item);
}
std::vector<core::ItemId> Engine::hidden_items() const {
  return impl_->overrides().hidden_items();
}
core::Expected<std::vector<core::ItemId>> Engine::items_below(std::span<const core::NodeId> nodes) const {
  return impl_->items_below(nodes);
}
void Engine::drop_context() {
  impl_->drop_context();
}
core::Expected<void> Engine::use_context(gl::Context& context) {
  return impl_->use_context(context);
}
core::Expected<bool> Engine::use_context(gl::Context& context, double seconds) {
  return impl_->use_context(context, seconds);
}
void Engine::paused() {
  impl_->paused();
}
void Engine::finish() {
  impl_->finish();
}
const Plan& Engine::plan() const {
  return impl_->plan();
}
const core::Snapshot& Engine::snapshot() const {
  return impl_->snapshot();
}
const gpuprims::Joints& Engine::joints() const {
  return impl_->joints();
}
const core::VisibleSet& Engine::visible() const {
  return impl_->visible();
}
const culling::Controller* Engine::controller() const {
  return impl_->controller();
}
Drawing* Engine::drawing() {
  return impl_->drawing();
}
std::string Engine::renderer() {
  [[maybe_unused]] const auto kept = impl_->keep_state();
  const Drawing* drawing = impl_->drawing();
  return drawing ? drawing->renderer() : std::string();
}
std::vector<std::string> Engine::take_gl_errors() {
  [[maybe_unused]] const auto kept = impl_->keep_state();
  Drawing* drawing = impl_->drawing();
  return drawing ? drawing->take_gl_errors() : std::vector<std::string>();
}
MemoryReport Engine::memory() const {
  return impl_->memory();
}

// --- order of the items, plan ----------------------------------------------------------------------------------------

Engine::Impl::Impl(core::Scene& scene, const EngineConfig& config)
    : scene_(&scene), edits_(scene.subscribe()), config_(config) {
  config_.controller.frame_cost.rendering = config.draw;
  if (config.context_later) next_try_ = std::numeric_limits<double>::infinity();
}

core::Expected<void> Engine::Impl::build(const Progress& progress) {
  auto snapshot = std::make_unique<core::Snapshot>(*scene_);
  note_all_nodes();
  if (progress && !progress(kShareOfSnapshot)) return core::fail("engine: cancelled");
  overrides_.restore(*snapshot);
  live_ = make_order(std::move(snapshot), plan_request(config_, picks_));
  return follow_order();
}

/// Remembers where picks will find these items. Items keep their nodes.
void Engine::Impl::note_nodes([[maybe_unused]] std::span<const core::ItemId> inserted) {
#if SIGHTLINE_HAS_RAYTRACE
  nodes_.resize(scene_->item_slots());
  for (const core::ItemId item : inserted)
    if (scene_->contains_item(item)) nodes_[item] = scene_->node_of(item);
#endif
}

void Engine::Impl::note_all_nodes() {
#if SIGHTLINE_HAS_RAYTRACE
  nodes_.resize(scene_->item_slots());
  for (core::ItemId item = 0; item < nodes_.size(); ++item)
    if (scene_->contains_item(item)) nodes_[item] = scene_->node_of(item);
#endif
}

/// Brings in a new order when one is ready and the drawing has what it needs for it.
core::Expected<void> Engine::Impl::land() {
  if (!rebuild_) return {};
  if (rebuild_->finished()) {
    rebuild_.reset();
    return {};
  }
  if (!landing_) {
    Order made;
    if (!rebuild_->take(made)) return {};
    landing_ = std::move(made);
  }
  [[maybe_unused]] const auto kept = keep_state();
  const auto prepared = prepare_landing();
  if (!prepared) return tl::unexpected(prepared.error());
  if (!*prepared) return {};
  new_tracer_.interrupt(live_);
  Order former = std::exchange(live_, std::move(*landing_));
  landing_.reset();
  live_.follow_plan(plan_request(config_, picks_));  // settings may have changed since the rebuild began
  overrides_.reorder(*live_.snapshot);
  core::Expected<void> done;
  if (drawing_) {
    done = unless_lost(drawing_->take_order(*former.snapshot, *live_.snapshot, live_.joints, live_.plan.gpu_culls()));
    note_context();
    follow_hybrid();
  } else {
    done = follow_order();
  }
  rebuild_->retire(std::move(former));
  return done;
}

/// Works a little on what the drawing needs for the new order. Whether it has all.
core::Expected<bool> Engine::Impl::prepare_landing() {
  if (drawing_ && drawing_->lost()) drop_context();
  if (!drawing_) return true;
  const double seconds = std::clamp(kLandingShare * frame_seconds_, kLeastLanding, kMostLanding);
  auto done = drawing_->advance_order(*landing_->snapshot, landing_->joints, live_.plan.gpu_culls(),
                                      core::deadline_in(seconds));
  if (!done && drawing_->lost()) {
    drop_context();
    return true;
  }
  if (!done) abandon_rebuild();
  return done;
}

void Engine::Impl::abandon_rebuild() {
  landing_.reset();
  rebuild_.reset();
  if (drawing_) drawing_->abandon_order();
}

/// `edited`: of the live order, which shows it already.
void Engine::Impl::follow_in_landing(const core::SceneDelta& edited, std::span<const std::uint32_t> materials) {
  if (!landing_) return;
  std::vector<core::ItemId> items;
  for (const auto* list : {&edited.removed, &edited.changed, &edited.inserted})
    items.insert(items.end(), list->begin(), list->end());
  std::sort(items.begin(), items.end());
  items.erase(std::unique(items.begin(), items.end()), items.end());
  core::Snapshot::Items copies;
  live_.snapshot->copy(items, copies);
  const std::vector<core::Slot> touched = catch_up(*landing_, items, copies);
  if (drawing_) drawing_->follow_later(touched, materials);
}

/// Updates everything that depends on the plan and on the order of the items, except the CPU culler.
core::Expected<void> Engine::Impl::follow_order() {
  auto done = make_drawing(true);
  follow_hybrid();
  return done;
}

void Engine::Impl::follow_hybrid() {
  const std::size_t items = live_.snapshot->size();
  if (live_.plan.culler != CullerChoice::kHybrid)
    hybrid_.reset();
  else if (hybrid_)
    hybrid_->scene_changed(items);
  else
    hybrid_.emplace(controller_config(), items, frames_);
  if (hybrid_ && !drawing_) hybrid_->gpu_lost();
}

culling::ControllerConfig Engine::Impl::controller_config() const {
  culling::ControllerConfig config = config_.controller;
  double& excess = config.frame_cost.presumed_gpu_excess;
  if (excess == 0.0 && drawing_ && drawing_->software()) excess = kSoftwareGpuExcess;
  return config;
}

core::Expected<void> Engine::Impl::configure(const EngineConfig& config) {
  if (auto good = check(config); !good) return good;
  if (const char* fixed = fixed_setting_that_differs(config_, config))
    return core::fail(std::string("engine: another engine is needed for another ") + fixed);
  const EngineConfig before = std::exchange(config_, config);
  config_.controller.frame_cost.rendering = config.draw;
  const CullerChoice culler_before = live_.plan.culler;
  live_.follow_plan(plan_request(config_, picks_));
  if (auto done = make_drawing(false); !done) {
    config_ = before;
    live_.follow_plan(plan_request(config_, picks_));
    note_context();
    return done;
  }
  for (Drawing* drawing : {drawing_.get(), coming_.get()})
    if (drawing) drawing->configure(config_);
  const bool same_culler = live_.plan.culler == culler_before;
  if (!same_culler) abandon_rebuild();  // it would land with the former culler
  if (same_culler && cost_alike(before, config_)) return {};
  hybrid_.reset();
  follow_hybrid();
  return {};
}

core::Expected<void> Engine::Impl::fit_target(const core::ExternalTarget& target) {
  if (!config_.draw || !config_.context)
    return core::fail(
        "engine: an external target needs EngineConfig::draw and the application's EngineConfig::context");
  if (target.width == config_.width && target.height == config_.height) return {};
  return resize(target.width, target.height);
}

core::Expected<void> Engine::Impl::resize(int width, int height) {
  [[maybe_unused]] const auto kept = keep_state();
  if (drawing_ && config_.draw)
    if (auto done = unless_lost(drawing_->resize(width, height)); !done) return done;
  if (coming_ && config_.draw)
    if (auto done = coming_->resize(width, height); !done) {
      const bool lost = coming_->lost();
      coming_.reset();
      if (!lost) return done;
    }
  config_.width = width;
  config_.height = height;
  return {};
}

core::Expected<void> Engine::Impl::use_picture(std::uint32_t number) {
  [[maybe_unused]] const auto kept = keep_state();
  const std::pair before(config_.width, config_.height);
  const auto known = sizes_.find(number);
  const auto [width, height] = known != sizes_.end() && number != picture_ ? known->second : before;
  if (drawing_)
    if (auto done = unless_lost(drawing_->use_picture(number, width, height)); !done) return done;
  sizes_[picture_] = before;
  picture_ = number;
  config_.width = width, config_.height = height;
  return {};
}

core::Expected<void> Engine::Impl::forget_picture(std::uint32_t number) {
  if (number == picture_)
    return core::fail("engine: forget_picture: expected a picture that is not in use, found " + std::to_string(number));
  sizes_.erase(number);
  if (!drawing_) return {};
  [[maybe_unused]] const auto kept = keep_state();
  if (drawing_->make_current()) drawing_->forget_picture(number);
  return {};
}

core::Expected<std::vector<FrameReport>> Engine::Impl::frame(std::span<const core::View> views,
                                                             std::span<const core::ExternalTarget> targets) {
  if (views.size() != targets.size())
    return core::fail("engine: expected as many targets as views, found " + std::to_string(targets.size()) + " for " +
                      std::to_string(views.size()));
  [[maybe_unused]] const auto kept = keep_state();
  const std::uint32_t before = picture_;
  const double began = now_seconds(), share = 1e-3 * config_.budget_ms / double(std::max<std::size_t>(views.size(), 1));
  std::vector<FrameReport> reports;
  core::Expected<void> done;
  for (std::size_t i = 0; done && i < views.size(); ++i) {
    done = use_picture(std::uint32_t(i));
    if (!done) break;
    // The budget of the last view ends with that of all, and each view may use what those before it have left.
    auto report = frame(views[i], views[i], &targets[i], began - share * double(views.size() - 1 - i));
    if (report)
      reports.push_back(*report);
    else
      done = tl::unexpected(report.error());
  }
  if (auto back = use_picture(before); done) done = back;
  if (!done) return tl::unexpected(done.error());
  return reports;
}

core::Expected<FrameReport> Engine::Impl::frame(const core::View& view, const core::View& cull_view,
                                                const core::ExternalTarget* target) {
  return frame(view, cull_view, target, now_seconds());
}

/// `budget_began`: when the time of a budget began to run, seconds on the steady clock.
core::Expected<FrameReport> Engine::Impl::frame(const core::View& view, const core::View& cull_view,
                                                const core::ExternalTarget* target, double budget_began) {
  [[maybe_unused]] const auto kept = keep_state();
  if (target)
    if (auto fits = fit_target(*target); !fits) return tl::unexpected(fits.error());
  if (auto landed = land(); !landed) return tl::unexpected(landed.error());
  FrameReport report;
  report.frame = frames_++;
  const double begin = now_seconds();
  if (last_frame_began_ >= 0.0) report.frame_ms = 1e3 * (begin - last_frame_began_);
  last_frame_began_ = begin;
  frame_seconds_ = 1e-3 * report.frame_ms;
  look_after_context();
  const bool aside = !core::same_picture(view, cull_view);
  const bool shows_hidden = aside && config_.hidden_colour && config_.draw && drawing_;
  const auto on_gpu = cull(cull_view, view, shows_hidden, report);
  if (!on_gpu) return tl::unexpected(on_gpu.error());
  if (drawing_) {
    const double culled = now_seconds();
    drawing_->put_into(target);
    if (aside && !shows_hidden) drawing_->picture_changed();
    const auto visible_in = [&](const core::View& of) {
      return Culled{of, *live_.snapshot, visible_, live_.lines, live_.hierarchy()};
    };
    const Culled over{view, *live_.snapshot, overlaid_, live_.lines, live_.hierarchy()};
    const bool overlays = *on_gpu && drawing_->has_overlays();
    if (overlays) std::visit([&](const auto& culler) { culler.cull(cull_view, overlaid_); }, *live_.culler);
    auto done = *on_gpu        ? drawing_->draw_culled(view, *live_.snapshot, report.frame, overlays ? &over : nullptr)
                : shows_hidden ? drawing_->draw_from_aside(view, visible_in(cull_view), report.frame, budget_began)
                               : drawing_->draw(visible_in(view), report.frame, budget_began, !aside);
    report.drawn = config_.draw && done;
    if (done = unless_lost(std::move(done)); !done) return tl::unexpected(done.error());
    report.draw_ms = 1e3 * (now_seconds() - culled);
    report.wait_ms = drawing_->waited_ms();
    if (report.drawn && !*on_gpu) {
      report.sampled = drawing_->counts().sampled;
      report.shown = drawing_->counts().shown;
      report.small = drawing_->counts().small;
      report.pending = drawing_->counts().pending;
      report.squares = drawing_->counts().squares;
    }
  }
  if (hybrid_ && !shows_hidden) hybrid_->measured(report, describe_walk());
  return report;
}

core::Expected<FrameReport> Engine::Impl::frame_part(const core::View& whole, const PicturePart& part) {
  const auto view = culling::rectangle_view(whole, part.width, part.height, part.x, part.y, part.x + config_.width,
                                            part.y + config_.height);
  if (!view) return tl::unexpected(view.error());
  [[maybe_unused]] const auto kept = keep_state();
  if (auto landed = land(); !landed) return tl::unexpected(landed.error());
  if (!drawing_ || !drawing_->blends()) return frame(*view, *view, nullptr);
  // Near surfaces weigh more than those behind them, as the whole picture says.
  std::visit([&](const auto& culler) { culler.cull(whole, overlaid_); }, *live_.culler);
  drawing_->set_blend_range(drawing_->blend_range(whole, *live_.snapshot, overlaid_));
  auto report = frame(*view, *view, nullptr);
  if (drawing_) drawing_->set_blend_range({});
  return report;
}

/// True when the GPU culled: then the result stays there, and visible() is empty. `on_cpu`: the CPU must cull; a hybrid
/// does not learn from that.
core::Expected<bool> Engine::Impl::cull(const core::View& cull_view, const core::View& view, bool on_cpu,
                                        FrameReport& report) {
  visible_.clear();
  visible_.generation = live_.snapshot->generation();
  bool on_gpu = drawing_ && live_.plan.culler == CullerChoice::kGpu && !on_cpu;
  gather_late_reports();
  if (hybrid_ && on_cpu) {
    hybrid_->paused();
    report.state = hybrid_->controller().state();
  } else if (hybrid_) {
    on_gpu = hybrid_->next(report.frame_ms) == culling::CullPath::kGpu;
    report.state = hybrid_->controller().state();
  }
  if (on_gpu) {
    const double begin = now_seconds();
    const auto done = drawing_->cull(cull_view, view, *live_.snapshot, report.frame);
    if (done) {
      report.culler = CullerChoice::kGpu;
      report.cull_ms = 1e3 * (now_seconds() - begin);
      report.visible = report.tested = -1;
      return true;
    }
    if (hybrid_)
      hybrid_->gpu_lost();  // the CPU culls instead
    else if (auto error = unless_lost(done); !error)
      return tl::unexpected(error.error());
  }
  cull_on_cpu(cull_view, report);
  return false;
}

void Engine::Impl::cull_on_cpu(const core::View& view, FrameReport& report) {
  const double begin = now_seconds();
  std::visit([&](const auto& culler) { culler.cull(view, visible_); }, *live_.culler);
  report.cull_ms = 1e3 * (now_seconds() - begin);
  report.culler =
      std::holds_alternative<culling::CpuCuller>(*live_.culler) ? CullerChoice::kCpu : CullerChoice::kLinear;
  report.visible = std::int64_t(live_.snapshot->count(visible_));
  report.tested = std::int64_t(visible_.counters.nodes_tested + visible_.counters.boxes_tested);
}

/// Empty unless the policy is that of the dissertation: no other reads it.
culling::FrameSample Engine::Impl::describe_walk() const {
  culling::FrameSample walk;
  const auto* culler = std::get_if<culling::CpuCuller>(live_.culler.get());
  if (culler && config_.controller.policy == culling::Policy::k2009) culler->describe(visible_.counters, walk);
  return walk;
}

void Engine::Impl::gather_late_reports() {
  constexpr std::size_t kMost = 64;
  if (!drawing_) return;
  if (hybrid_)
    while (const auto drawn = drawing_->take_drawn()) hybrid_->drawn(drawn->frame, drawn->gpu_ms);
  while (const auto feedback = drawing_->take_gpu_feedback()) {
    late_.push_back({feedback->frame, std::int64_t(feedback->visible), feedback->time_ms.value_or(-1.0),
                     config_.draw ? std::int64_t(feedback->shown) : -1});
    if (hybrid_) hybrid_->measured(late_.back());
    if (late_.size() > kMost) late_.pop_front();
  }
}

std::optional<LateReport> Engine::Impl::take_late_report() {
  if (live_.plan.gpu_culls()) {
    [[maybe_unused]] const auto kept = keep_state();
    gather_late_reports();
  }
  if (late_.empty()) return std::nullopt;
  const LateReport oldest = late_.front();
  late_.pop_front();
  return oldest;
}

core::Expected<bool> Engine::Impl::commit(core::Deadline deadline) {
  if (auto landed = land(); !landed) return tl::unexpected(landed.error());
  if (auto published = scene_->commit(); !published) return tl::unexpected(published.error());
  const bool at_once = deadline == core::kNoDeadline || config_.part.count > 1;
  for (;;) {
    if (edits_left_.empty()) edits_left_ = edits_.take();
    if (edits_left_.empty()) return true;
    core::SceneDelta piece = at_once ? std::exchange(edits_left_, {}) : first_of(edits_left_);
    if (auto done = follow(std::move(piece)); !done) return tl::unexpected(done.error());
    if (core::over(deadline)) return false;
  }
}

/// Shows what the scene now has of the edited items.
core::Expected<void> Engine::Impl::follow(core::SceneDelta delta) {
  new_tracer_.interrupt(live_);
  if (config_.part.count > 1) return build();
  note_nodes(delta.inserted);
  const std::size_t former_size = live_.snapshot->size();
  std::vector<core::Slot> touched;
  Overrides::Change overridden;
  const auto apply = [&] {
    touched = live_.snapshot->apply(delta);
    overridden = overrides_.follow(*live_.snapshot, delta, touched);
    for (const core::Slot slot : overridden.touched) delta.changed.push_back(live_.snapshot->item(slot));
  };
  rebuild_ ? rebuild_->edit(delta, apply) : apply();
  if (!overridden.touched.empty()) add_slots(overridden.touched, former_size, touched);
  live_.follow({delta.removed, delta.changed, delta.inserted, overridden.uncovered}, !delta.materials.empty(),
               former_size, touched);
  new_tracer_.follow(live_);
  const bool items_edited = delta.size() > delta.materials.size();  // materials do not change what frames cost
  if (hybrid_ && items_edited) hybrid_->scene_changed(live_.snapshot->size());
  const double disorder = double(live_.snapshot->disorder());
  if (!rebuild_ && config_.rebuild_share > 0.0 && disorder > kFewSlots &&
      disorder > config_.rebuild_share * double(live_.snapshot->size()))
    rebuild_ = std::make_unique<BackgroundRebuild>(*live_.snapshot, plan_request(config_, picks_));
  if (live_.snapshot->size() > former_size) Drawing::plan_programs(live_.plan, *live_.snapshot, config_.draw);
  delta.materials.insert(delta.materials.end(), overridden.materials.begin(), overridden.materials.end());
  follow_in_landing(delta, delta.materials);
  if (coming_) coming_->follow_later(touched, delta.materials);
  if (!drawing_) return {};
  [[maybe_unused]] const auto kept = keep_state();
  return unless_lost(drawing_->update(*live_.snapshot, live_.joints, touched, delta.materials));
}

core::Expected<void> Engine::Impl::rebuild() {
  if (auto delta = scene_->commit(); !delta) return tl::unexpected(delta.error());
  edits_ = scene_->subscribe();  // the new snapshot shows all edits
  edits_left_ = {};
  new_tracer_.interrupt(live_);
  abandon_rebuild();
  return build();
}

void Engine::Impl::paused() {
  last_frame_began_ = -1.0;
  if (hybrid_) hybrid_->paused();
}

void Engine::Impl::finish() {
  [[maybe_unused]] const auto kept = keep_state();
  if (drawing_) drawing_->finish();
}

Drawing* Engine::Impl::drawing() {
  if (drawing_ && !drawing_->make_current()) return nullptr;
  return drawing_.get();
}

MemoryReport Engine::Impl::memory() const {
  MemoryReport report;
  report.scene = scene_->memory_bytes();
  report.snapshot = overrides_.memory_bytes();
  for (const Order* order : {&live_, landing_ ? &*landing_ : nullptr}) {
    if (!order) continue;
    report.snapshot += order->snapshot->memory_bytes() + order->joints.memory_bytes();
    if (const auto* culler = std::get_if<culling::CpuCuller>(order->culler.get())) report.bvh += culler->memory_bytes();
    report.tracer += tracer_bytes(*order);
  }
  if (drawing_) report.gpu = drawing_->memory_bytes();
  return report;
}

// --- overrides -------------------------------------------------------------------------------------------------------

core::Expected<void> Engine::Impl::known(const char* call, std::span<const core::ItemId> items) const {
  for (const core::ItemId item : items)
    if (live_.snapshot->slot(item) == core::kNone)
      return core::fail("engine: " + std::string(call) + ": no item " + std::to_string(item) +
                        " as of the last commit");
  return {};
}

/// Lets `edit` change the overrides and the snapshot, and everything follow that depends on them.
template <class Edit>
core::Expected<void> Engine::Impl::override_items(const Edit& edit) {
  new_tracer_.interrupt(live_);
  Overrides::Change change;
  core::SceneDelta edited;
  const auto apply = [&] {
    change = edit(*live_.snapshot);
    if (rebuild_)
      for (const core::Slot slot : change.touched) edited.changed.push_back(live_.snapshot->item(slot));
  };
  rebuild_ ? rebuild_->edit(edited, apply) : apply();
  if (!change.touched.empty()) live_.follow_overrides(change.uncovered, change.boxes, change.touched);
  new_tracer_.follow(live_);
  if (change.touched.empty()) return {};
  if (hybrid_ && change.boxes) hybrid_->scene_changed(live_.snapshot->size());
  follow_in_landing(edited, change.materials);
  if (coming_) coming_->follow_later(change.touched, change.materials);
  if (!drawing_) return {};
  [[maybe_unused]] const auto kept = keep_state();
  return unless_lost(drawing_->update_looks(*live_.snapshot, live_.joints, change.touched, change.materials));
}

core::Expected<void> Engine::Impl::set_override(std::span<const core::ItemId> items, const ItemStyle& style) {
  const auto in_range = [](float value) { return value >= 0.0f && value <= 1.0f; };
  if (!in_range(style.alpha)) return core::fail("engine: set_override: alpha must be within 0 and 1");
  if (style.colour && !(in_range(style.colour->r) && in_range(style.colour->g) && in_range(style.colour->b)))
    return core::fail("engine: set_override: colour must be within 0 and 1");
  if (auto good = known("set_override", items); !good) return good;
  return override_items([&](core::Snapshot& snapshot) { return overrides_.set(snapshot, items, style); });
}

core::Expected<void> Engine::Impl::clear_override(std::span<const core::ItemId> items) {
  if (auto good = known("clear_override", items); !good) return good;
  return override_items([&](core::Snapshot& snapshot) { return overrides_.clear(snapshot, items); });
}

core::Expected<void> Engine::Impl::clear_overrides() {
  return override_items([&](core::Snapshot& snapshot) { return overrides_.clear_all(snapshot); });
}

core::Expected<void> Engine::Impl::hide(std::span<const core::ItemId> items) {
  if (auto good = known("hide", items); !good) return good;
  return override_items([&](core::Snapshot& snapshot) { return overrides_.hide(snapshot, items); });
}

core::Expected<void> Engine::Impl::show(std::span<const core::ItemId> items) {
  if (auto good = known("show", items); !good) return good;
  return override_items([&](core::Snapshot& snapshot) { return overrides_.show(snapshot, items); });
}

core::Expected<std::vector<core::ItemId>> Engine::Impl::items_below(std::span<const core::NodeId> nodes) const {
  std::vector<core::ItemId> items;
  for (const core::NodeId top : nodes) {
    if (!scene_->contains(top))
      return core::fail("engine: no node " + std::to_string(top.index) + " of generation " +
                        std::to_string(top.generation));
    scene_->for_each_node(top, [&](core::NodeId node, const auto&...) {
      for (core::ItemId item = scene_->first_item(node); item != core::kNone; item = scene_->next_item(item))
        if (live_.snapshot->slot(item) != core::kNone) items.push_back(item);
    });
  }
  std::sort(items.begin(), items.end());
  items.erase(std::unique(items.begin(), items.end()), items.end());
  return items;
}

core::Expected<void> Engine::Impl::isolate(std::span<const core::NodeId> nodes) {
  const auto inside = items_below(nodes);
  if (!inside) return tl::unexpected(inside.error());
  std::vector<bool> below(scene_->item_slots());
  for (const core::ItemId item : *inside) below[item] = true;
  std::vector<core::ItemId> outside;
  for (core::Slot slot = 0; slot < live_.snapshot->size(); ++slot) {
    const core::ItemId item = live_.snapshot->item(slot);
    if (item != core::kNone && !below[item]) outside.push_back(item);
  }
  if (auto done = show(*inside); !done) return done;
  return hide(outside);
}

core::Expected<void> Engine::Impl::show_all() {
  return override_items([&](core::Snapshot& snapshot) { return overrides_.show_all(snapshot); });
}

}  // namespace sightline::engine
