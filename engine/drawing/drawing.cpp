#include "sightline/engine/drawing/internal/drawing.h"

#include <utility>

#include "sightline/core/internal/clock.h"
#include "sightline/core/internal/store.h"
#include "sightline/engine/drawing/internal/left_out.h"
#include "sightline/engine/internal/settings.h"
#include "sightline/gl/internal/program_cache.h"
#if SIGHTLINE_HAS_RAYTRACE
#include "sightline/engine/traced/internal/traced_drawing.h"
#endif

namespace sightline::engine {
namespace {

constexpr double kLevelsSeconds = 0.004;  // of a frame, to upload levels of detail

}  // namespace

core::Expected<std::unique_ptr<Backend>> make_backend(const EngineConfig& config, const Overrides& overrides) {
#if SIGHTLINE_HAS_RAYTRACE
  const Renderer renderer = config.draw ? config.drawing.renderer : Renderer::kGl;
  if (traces_until_context(config))
    return std::make_unique<TracedDrawing>(config, overrides, "there is no context yet");
  if (renderer == Renderer::kRays) return std::make_unique<TracedDrawing>(config, overrides, "asked for");
  auto made = Drawing::create(config, overrides);
  if (!made && renderer == Renderer::kAutomatic && check_rays(config))
    return std::make_unique<TracedDrawing>(config, overrides, made.error().message);
  return made;
#else
  return Drawing::create(config, overrides);
#endif
}

// --- context ---------------------------------------------------------------------------------------------------------

core::Expected<std::unique_ptr<Drawing>> Drawing::create(const EngineConfig& config, const Overrides& overrides) {
  std::optional<gl::Context> own;
  if (!config.context.application) {
    gl::ContextOptions options;
    options.platform = config.context.platform;
    options.debug = config.context.gl_debug;
    if (auto done = core::store(gl::Context::create_offscreen(options), own); !done)
      return tl::unexpected(done.error());
  }
  gl::Context shared = (config.context.application ? *config.context.application : *own).share();
  std::unique_ptr<Drawing> drawing(new Drawing(std::move(own), std::move(shared), config, overrides));
  if (auto current = drawing->make_current(); !current) return tl::unexpected(current.error());
  const auto kept = drawing->keep_state();
  drawing->context_.context.cache_programs(config.context.program_cache.value_or(gl::ProgramCache::default_folder()));
  drawing->context_.context.test_driver();
  if (config.draw) {
    auto target = render::RenderTarget::create(drawing->context_.context, config.width, config.height,
                                               {.ids = config.drawing.ids, .samples = config.drawing.samples});
    if (!target) return tl::unexpected(target.error());
    drawing->context_.image->target = std::move(*target);
  }
  drawing->upload_.begin();
  return drawing;
}

Drawing::~Drawing() {
  own_context_.reset();  // frees everything in it without changing which context is current
  (void)make_current();
}

std::vector<std::string> Drawing::take_gl_errors() {
  return make_current() ? context_.context.take_errors() : std::vector<std::string>();
}

// --- settings and images ---------------------------------------------------------------------------------------------

void Drawing::configure(const EngineConfig& config) {
  if (config.losses.min_projected_area != context_.config.losses.min_projected_area)
    for (auto& [number, image] : context_.images) image.was_large.clear();
  context_.config = config;
  if (context_.scene && context_.renderer && wants_levels()) context_.mesh_details.want_levels(*context_.scene);
  images_changed();
}

void Drawing::set_losses(const LossConfig& losses) {
  EngineConfig changed = context_.config;
  changed.losses = losses;
  configure(changed);
}

core::Expected<void> Drawing::resize(int width, int height) {
  if (auto current = make_current(); !current) return current;
  if (auto done = core::store(make_target(width, height), context_.image->target); !done) return done;
  context_.image->resized();
  image_changed();
  return {};
}

core::Expected<void> Drawing::use_image(std::uint32_t number, int width, int height) {
  auto& images = context_.images;
  const auto present = images.find(number);
  const bool fits =
      present != images.end() && present->second.target.width() == width && present->second.target.height() == height;
  if (!context_.config.draw || (fits && context_.image == &present->second)) return {};
  if (!fits) {
    if (auto current = make_current(); !current) return current;
    auto target = make_target(width, height);
    if (!target) return tl::unexpected(target.error());
    images[number] = {};
    images[number].target = std::move(*target);
  }
  context_.image = &images[number];
  unseen_.reset();
  return {};
}

void Drawing::forget_image(std::uint32_t number) {
  if (make_current()) context_.images.erase(number);
}

// --- frames ----------------------------------------------------------------------------------------------------------

core::Expected<void> Drawing::cull(const Frame& frame) {
  if (auto current = make_current(); !current) return current;
  if (auto done = follow_levels(core::deadline_in(kLevelsSeconds)); !done) return done;
  if (auto made = add_culler(frame.snapshot); !made) return made;
  auto done = culling_.cull(context_, frame);
  if (!done) culling_.use(std::nullopt);  // what it has of the scene may be incomplete; the next call makes another
  return done;
}

core::Expected<DrawResult> Drawing::draw(const Frame& frame, const core::VisibleSet& visible, bool on_gpu) {
  DrawResult result;
  if (!context_.renderer && !on_gpu) return result;
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  if (!on_gpu)  // else cull() has done so: what it has found lies where the meshes were then
    if (auto done = follow_levels(core::deadline_in(kLevelsSeconds)); !done) return tl::unexpected(done.error());
  if (on_gpu || (!frame.shows_unseen && (frame.aside() || unseen_.active()))) image_changed();
  result.wait_ms = queue_.wait_for_room();
  if (context_.renderer) {
    give_looks(context_.config.drawing.looks, *context_.renderer, frame.rows);
    const core::VisibleSet& opaque = overlays_.split(context_, visible);
    auto counts = frame.shows_unseen ? draw_with_unseen(frame, opaque)
                  : on_gpu           ? draw_culled(frame)
                                     : opaque_.draw(context_, frame, opaque, overlays_.items());
    if (!counts) return tl::unexpected(counts.error());
    if (auto done = overlays_.finish(context_, frame, visible, *counts); !done) return tl::unexpected(done.error());
    result.counts = *counts;
    result.counts.triangles = context_.image->meshes.triangles + context_.image->meshes_over.triangles;
  }
  queue_.submit(frame.number);
  return result;
}

/// Draws what the GPU has culled.
core::Expected<DrawCounts> Drawing::draw_culled(const Frame& frame) {
  context_.image->pyramid_valid = context_.image->unchanged = false;
  context_.image->meshes = {};
  return culling_.draw(context_, frame).map([] { return DrawCounts(); });
}

/// Draws what the image of the view that was culled for shows as it is, and the other visible items in one colour.
core::Expected<DrawCounts> Drawing::draw_with_unseen(const Frame& frame, const core::VisibleSet& opaque) {
  if (auto done = unseen_.split(context_, frame, opaque); !done) return tl::unexpected(done.error());
  auto counts = opaque_.draw(context_, frame, unseen_.seen());
  if (!counts) return counts;
  const auto unseen = unseen_.draw(context_, frame);
  if (!unseen) return tl::unexpected(unseen.error());
  counts->items_drawn += *unseen;
  return counts;
}

std::optional<LateReport> Drawing::take_late_report() {
  if (!culling_.culler() || !make_current()) return std::nullopt;
  const auto feedback = culling_.take_feedback();
  if (!feedback) return std::nullopt;
  return LateReport{feedback->frame, std::int64_t(feedback->visible), feedback->time_ms.value_or(-1.0),
                    context_.config.draw ? std::int64_t(feedback->items_drawn) : -1};
}

void Drawing::finish() {
  if (make_current()) queue_.finish();
}

// --- queries ---------------------------------------------------------------------------------------------------------

core::Expected<LeftOut> Drawing::left_out(const Frame& frame, const core::VisibleSet& visible) {
  if (!context_.renderer) return LeftOut();
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  image_changed();
  (void)queue_.wait_for_room();
  return find_left_out(context_, overlays_, frame, visible);
}

core::Expected<LossReport> Drawing::loss(const Frame& frame, const core::VisibleSet& visible) {
  if (!context_.renderer) return LossReport();
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  return measure_loss(context_, frame, visible);
}

BackendReport Drawing::report() const {
  BackendReport report{context_.context.platform(), context_.context.renderer(), context_.config.context.application};
  if (culling_.culler()) report.gpu_variant = culling_.culler()->variant();
  report.why_gpu_variant = culling_.why_variant();
  report.levels_bytes = context_.mesh_details.memory_bytes();
  std::size_t& bytes = report.gpu_bytes = upload_.memory_bytes() + culling_.memory_bytes() + overlays_.memory_bytes();
  if (!context_.scene) return report;
  bytes += context_.scene->memory_bytes() + context_.lists->memory_bytes();
  if (!context_.renderer) return report;
  for (const auto& [number, image] : context_.images) {
    bytes += image.memory_bytes();
    report.points_bytes += image.traced ? image.traced->points_bytes() : 0;
  }
  bytes += context_.renderer->memory_bytes() + opaque_.memory_bytes();
  return report;
}

}  // namespace sightline::engine
