#include "sightline/engine/drawing/internal/drawing.h"

#include <algorithm>
#include <array>
#include <utility>

#include "sightline/core/internal/clock.h"
#include "sightline/engine/drawing/internal/left_out.h"
#include "sightline/engine/drawing/internal/warm_up.h"
#include "sightline/engine/internal/settings.h"
#include "sightline/gl/internal/current_context.h"
#include "sightline/gl/internal/program_cache.h"
#include "sightline/gl/internal/saved_state.h"

namespace sightline::engine {
namespace {

constexpr double kLevelsSeconds = 0.004;  // of a frame, to upload levels of detail
constexpr int kWarmUpSize = 64;           // pixels a side, of images that are drawn to make the driver compile
constexpr double kBudgetShare = 0.93;     // of a frame's budget, to draw in

struct KeptCurrentContext : KeptState {
  gl::CurrentContext context;
};
struct KeptContextState : KeptState {
  explicit KeptContextState(const gl::Functions& gl) : state(gl) {}
  gl::SavedState state;
};

}  // namespace

std::unique_ptr<KeptState> keep_current_context() {
  return std::make_unique<KeptCurrentContext>();
}

core::Expected<std::unique_ptr<Backend>> make_backend(const EngineConfig& config, const Overrides& overrides) {
  return Drawing::create(config, overrides);
}

namespace {

/// Items of each kind of batches.
std::array<std::size_t, gpuscene::kBatchKindCount> count_batches(const core::Snapshot& snapshot) {
  std::array<std::size_t, gpuscene::kBatchKindCount> counts{};
  for (int kind = 0; kind < core::kKindCount; ++kind)
    counts[std::size_t(gpuscene::batch_of(core::Kind(kind)))] += snapshot.of_kind(core::Kind(kind)).size();
  return counts;
}

std::vector<gpuscene::BatchKind> batches_of(const core::Snapshot& snapshot) {
  const auto counts = count_batches(snapshot);
  std::vector<gpuscene::BatchKind> kinds;
  for (int i = 0; i < gpuscene::kBatchKindCount; ++i)
    if (counts[std::size_t(i)] > 0) kinds.push_back(gpuscene::BatchKind(i));
  return kinds;
}

}  // namespace

void plan_programs(Plan& plan, const core::Snapshot& snapshot, bool draw) {
  const auto counts = count_batches(snapshot);
  for (int i = 0; i < gpuscene::kBatchKindCount; ++i) {
    const auto batch = gpuscene::BatchKind(i);
    const std::size_t n = counts[std::size_t(i)];
    std::string feature(gpuscene::name_of(batch));
    std::replace(feature.begin(), feature.end(), '_', ' ');
    feature += gpuscene::is_ray_cast(batch) ? " program (ray-cast)" : " program";
    const std::string why = !draw ? "drawing is off" : n > 0 ? count_text(n) : "none in the scene";
    set_entry(plan, {std::move(feature), draw && n > 0, why});
  }
}

// --- context ---------------------------------------------------------------------------------------------------------

core::Expected<std::unique_ptr<Drawing>> Drawing::create(const EngineConfig& config, const Overrides& overrides) {
  std::optional<gl::Context> own;
  if (!config.context.application) {
    gl::ContextOptions options;
    options.platform = config.context.platform;
    options.debug = config.context.gl_debug;
    auto made = gl::Context::create_offscreen(options);
    if (!made) return tl::unexpected(made.error());
    own = std::move(*made);
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

Drawing::Drawing(std::optional<gl::Context> own, gl::Context shared, const EngineConfig& config,
                 const Overrides& overrides)
    : context_(std::move(shared), config),
      own_context_(std::move(own)),
      queue_(context_.gl()),
      overlays_(TranslucentSlots(overrides, config.draw && config.drawing.transparency == Transparency::kBlended)) {}

Drawing::~Drawing() {
  own_context_.reset();  // frees everything in it without changing which context is current
  (void)make_current();
}

std::unique_ptr<KeptState> Drawing::keep_state() const {
  if (context_.config.context.gl_state == GlState::kLeave) return nullptr;
  if (own_context_) return keep_current_context();
  return lost() ? nullptr : std::make_unique<KeptContextState>(context_.gl());
}

bool Drawing::lost() const {
  (void)make_current();
  return context_.context.lost();
}

std::vector<std::string> Drawing::take_gl_errors() {
  return make_current() ? context_.context.take_errors() : std::vector<std::string>();
}

// --- scene versions -------------------------------------------------------------------------------------------------

core::Expected<bool> Drawing::advance(const core::Snapshot& snapshot, const gpuprims::Joints& joints, bool gpu_culls,
                                      core::Deadline deadline) {
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  const auto kept = keep_state();
  if (upload_.active()) {
    const auto done = advance_upload(snapshot, joints, gpu_culls, deadline);
    if (!done || !*done) return done;
    if (auto taken = take_upload(snapshot); !taken) return tl::unexpected(taken.error());
  }
  if (const auto done = warm_up(snapshot, deadline); !done || !*done) return done;
  const GpuEdits edits = upload_.take_edits();
  auto done = update(Edit::kItems, snapshot, joints, edits.touched, edits.materials, deadline);
  if (done) done = culling_.leave_out(context_, snapshot, overlaid());
  if (!done) return tl::unexpected(done.error());
  return context_.scene->upload_meshes(deadline);
}

core::Expected<bool> Drawing::advance_version(const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                              bool gpu_culls, core::Deadline deadline) {
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  if (!upload_.active()) upload_.begin();
  return advance_upload(snapshot, joints, gpu_culls, deadline);
}

core::Expected<void> Drawing::take_version(const core::Snapshot& former, const core::Snapshot& snapshot,
                                           const gpuprims::Joints& joints, bool gpu_culls) {
  if (auto current = make_current(); !current) return current;
  for (auto& [number, image] : context_.images) image.passes.follow(former, snapshot);
  if (auto done = take_upload(snapshot); !done) return done;
  const GpuEdits edits = upload_.take_edits();
  if (auto done = update(Edit::kItems, snapshot, joints, edits.touched, edits.materials, core::kNoDeadline); !done)
    return done;
  if (gpu_culls && !culling_.culler()) return add_culler(snapshot);
  return culling_.leave_out(context_, snapshot, overlaid());
}

core::Expected<void> Drawing::rebuild(const core::Snapshot& snapshot, const gpuprims::Joints& joints, bool gpu_culls) {
  if (auto current = make_current(); !current) return current;
  upload_.begin();
  if (context_.config.draw && own_context_ && !context_.renderer)
    engine::warm_up(context_.context, context_.config, context_.target().format(), batches_of(snapshot));
  if (auto done = advance_upload(snapshot, joints, gpu_culls, core::kNoDeadline); !done) {
    upload_.abandon();
    return tl::unexpected(done.error());
  }
  for (auto& [number, image] : context_.images) image.passes.reset();
  if (auto taken = take_upload(snapshot); !taken) return taken;
  context_.mesh_details.keep_only(*context_.scene, wants_levels());
  return culling_.leave_out(context_, snapshot, overlaid());
}

/// Draws what the upload has made from now on.
core::Expected<void> Drawing::take_upload(const core::Snapshot& snapshot) {
  GpuContent content = upload_.take();
  for (auto& [number, image] : context_.images) image.forget_slots();
  unseen_.reset();
  context_.solid_areas.reset();
  culling_.use(std::move(content.culler));
  context_.scene = std::move(content.scene);
  context_.lists = std::move(content.lists);
  packs_ = 0;
  if (content.renderer) context_.renderer = std::move(content.renderer);
  overlays_.translucent().reset(snapshot);
  if (!context_.renderer) return {};
  return context_.renderer->follow(*context_.scene, context_.target().format());
}

core::Expected<void> Drawing::add_culler(const core::Snapshot& snapshot) {
  if (culling_.culler() || !context_.scene) return {};
  if (auto current = make_current(); !current) return current;
  auto culler = culling_.make(context_, snapshot, *context_.scene);
  if (!culler) return tl::unexpected(culler.error());
  culling_.use(std::move(*culler));
  return culling_.leave_out(context_, snapshot, overlaid());
}

core::Expected<bool> Drawing::warm_up(const core::Snapshot& snapshot, core::Deadline deadline) {
  const std::vector<gpuscene::Batch>& batches = context_.scene->batches();
  if (context_.renderer && warmed_up_ < batches.size()) {
    // Drivers compile for the format of an image, whatever its size.
    auto small = make_target(kWarmUpSize, kWarmUpSize);
    if (!small) return tl::unexpected(small.error());
    std::swap(context_.image->target, *small);
    core::Expected<void> done;
    do done = draw_one(snapshot, batches[warmed_up_++]);
    while (done && warmed_up_ < batches.size() && !core::over(deadline));
    std::swap(context_.image->target, *small);
    if (!done) return tl::unexpected(done.error());
    if (core::over(deadline)) return false;
  }
  const EngineConfig& config = context_.config;
  return (config.losses.min_projected_area <= 0.0f && config.losses.budget_ms <= 0.0) ||
         context_.solid_areas.measure(snapshot, deadline);
}

/// Draws the first item of a batch that is not vacant, from near.
core::Expected<void> Drawing::draw_one(const core::Snapshot& snapshot, const gpuscene::Batch& batch) {
  core::VisibleSet one;
  one.generation = snapshot.generation();
  std::vector<core::Slot> slots = gpuscene::GpuScene::slots_of(snapshot, batch.kind);
  slots.resize(batch.count);  // those that came later have no records yet
  const auto shows = [&](core::Slot slot) { return !snapshot.vacant(slot); };
  const auto first = std::find_if(slots.begin(), slots.end(), shows);
  if (first == slots.end()) return {};
  one.single_slots = {*first};
  const core::Aabb box = snapshot.bounds().box(one.single_slots[0]);
  const core::dvec3 origin = snapshot.bounds().origin;
  const auto view =
      core::View::fit({origin + core::dvec3(box.min), origin + core::dvec3(box.max)}, core::kOverviewDirection, 0.9,
                      double(context_.target().width()) / context_.target().height());
  if (!view) return {};
  if (auto done = context_.draw(*view, snapshot, one); !done) return done;
  if (auto done = overlays_.draw_depth_shading(context_, *view); !done) return done;
  context_.gl().Finish();
  return {};
}

// --- edits -----------------------------------------------------------------------------------------------------------

core::Expected<void> Drawing::update(Edit edit, const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                     std::span<const core::Slot> touched, std::span<const std::uint32_t> materials,
                                     core::Deadline deadline) {
  if (auto current = make_current(); !current) return current;
  if (edit == Edit::kStyles) {
    context_.scene->update_styles(snapshot, touched, joints);
    return follow_edit(edit, snapshot, touched, materials);
  }
  const bool in_portions = deadline != core::kNoDeadline;
  const auto prepared = in_portions ? context_.scene->prepare_room() : core::Expected<bool>(false);
  const auto larger = context_.scene->append(snapshot, joints);
  if (!prepared || !larger) return rebuild(snapshot, joints, culling_.culler());  // the scene is of no use then
  context_.scene->update(snapshot, touched, joints);
  if (!context_.scene->upload_meshes(deadline)) return rebuild(snapshot, joints, culling_.culler());
  follow_meshes();
  if (*prepared || *larger)
    if (auto done = follow_batches(snapshot); !done) return done;
  return follow_edit(edit, snapshot, touched, materials);
}

core::Expected<bool> Drawing::upload_meshes(core::Deadline deadline) {
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  images_changed();
  return context_.scene->upload_meshes(deadline);
}

/// Makes anew what is kept for each batch, where batches are larger or new.
core::Expected<void> Drawing::follow_batches(const core::Snapshot& snapshot) {
  auto lists = gpuscene::DrawLists::create(context_.context, *context_.scene);
  if (!lists) return tl::unexpected(lists.error());
  context_.lists = std::move(*lists);
  if (context_.renderer)
    if (auto done = context_.renderer->follow(*context_.scene, context_.target().format()); !done) return done;
  if (!culling_.culler()) return {};
  culling_.use(std::nullopt);
  return add_culler(snapshot);
}

core::Expected<void> Drawing::follow_edit(Edit edit, const core::Snapshot& snapshot,
                                          std::span<const core::Slot> touched,
                                          std::span<const std::uint32_t> materials) {
  images_changed();
  if (auto done = context_.scene->update_materials(snapshot, materials); !done) return done;
  context_.solid_areas.update(snapshot, touched);
  const std::vector<core::Slot> turned = overlays_.translucent().update(snapshot, touched, materials);
  auto done = culling_.update(context_, snapshot, touched, overlaid(), edit == Edit::kItems);
  if (done && !turned.empty()) done = culling_.update(context_, snapshot, turned, overlaid(), false);
  return done;
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

core::Expected<render::RenderTarget> Drawing::make_target(int width, int height) const {
  return render::RenderTarget::create(context_.context, width, height, context_.target().format());
}

core::Expected<void> Drawing::resize(int width, int height) {
  if (auto current = make_current(); !current) return current;
  auto target = make_target(width, height);
  if (!target) return tl::unexpected(target.error());
  context_.image->target = std::move(*target);
  context_.image->refined.reset();
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

/// The next frame shows something else, though its view may be that of the last one: a budget begins anew.
void Drawing::image_changed() {
  context_.image->changed();
  unseen_.reset();
}

void Drawing::images_changed() {
  for (auto& [number, image] : context_.images) image.changed();
  unseen_.reset();
}

// --- frames ----------------------------------------------------------------------------------------------------------

core::Expected<void> Drawing::cull(const core::View& cull_view, const core::View& view, const core::Snapshot& snapshot,
                                   std::uint64_t frame) {
  if (auto current = make_current(); !current) return current;
  if (auto done = follow_levels(core::deadline_in(kLevelsSeconds)); !done) return done;
  if (auto made = add_culler(snapshot); !made) return made;
  auto done = culling_.cull(context_, cull_view, view, snapshot, frame);
  if (!done) culling_.use(std::nullopt);  // what it has of the scene may be incomplete; the next call makes another
  return done;
}

core::Expected<DrawResult> Drawing::draw(const DrawRequest& request) {
  DrawResult result;
  if (!context_.renderer && !request.on_gpu) return result;
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  if (!request.on_gpu)  // else cull() has done so: what it has found lies where the meshes were then
    if (auto done = follow_levels(core::deadline_in(kLevelsSeconds)); !done) return tl::unexpected(done.error());
  context_.external = request.target ? std::optional(*request.target) : std::nullopt;
  context_.image->composed = false;
  const bool aside = !core::same_image(request.view, request.culled.view);
  if (request.on_gpu || (!request.shows_unseen && (aside || unseen_.active()))) image_changed();
  result.wait_ms = queue_.wait_for_room();
  if (context_.renderer) {
    give_looks(context_.config.drawing.looks, *context_.renderer, request.rows);
    auto counts = request.shows_unseen ? draw_with_unseen(request) : draw_opaque(request, aside);
    if (!counts) return tl::unexpected(counts.error());
    const Culled visible = request.culled.seen_in(request.view);
    if (auto done = overlays_.finish(context_, visible, request.blend_range, *counts); !done)
      return tl::unexpected(done.error());
    result.counts = *counts;
    result.counts.triangles = context_.image->meshes.triangles + context_.image->meshes_over.triangles;
  }
  if (context_.external && !context_.image->composed)
    if (auto done = context_.compose(); !done) return tl::unexpected(done.error());
  queue_.submit(request.frame);
  return result;
}

DrawInput Drawing::input_of(const DrawRequest& request, const Culled& candidates, bool all_visible) const {
  const double deadline = request.budget_began + kBudgetShare * 1e-3 * context_.config.losses.budget_ms;
  return {candidates, deadline, all_visible, overlays_.any(context_)};
}

/// `aside`: the view is not the one that was culled for.
core::Expected<DrawCounts> Drawing::draw_opaque(const DrawRequest& request, bool aside) {
  const Culled culled = request.culled.seen_in(request.view);
  const core::VisibleSet& opaque = overlays_.split(context_, culled.visible);
  if (request.on_gpu) {
    context_.image->pyramid_valid = context_.image->unchanged = false;
    context_.image->meshes = {};
    return culling_.draw(context_, request.view, culled.snapshot).map([] { return DrawCounts(); });
  }
  return opaque_.draw(context_, input_of(request, culled.with(opaque), request.all && !aside));
}

/// Draws what the image of the view that was culled for shows as it is, and the other visible items in one colour.
core::Expected<DrawCounts> Drawing::draw_with_unseen(const DrawRequest& request) {
  const core::VisibleSet& opaque = overlays_.split(context_, request.culled.visible);
  if (auto done = unseen_.split(context_, request.culled.with(opaque)); !done) return tl::unexpected(done.error());
  const Culled seen = request.culled.with(unseen_.seen()).seen_in(request.view);
  auto counts = opaque_.draw(context_, input_of(request, seen, false));
  if (!counts) return counts;
  const auto unseen = unseen_.draw(context_, request.view, request.culled.snapshot);
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

/// Learns which meshes have come and gone, and gives back memory where they have become far fewer.
void Drawing::follow_meshes() {
  if (std::exchange(packs_, context_.scene->meshes().packs()) < packs_) context_.lists->trim();
  if (context_.renderer) return context_.mesh_details.follow(*context_.scene, wants_levels());
  (void)context_.scene->take_new_meshes(core::kNone);  // nobody else will, and their lists would grow
  (void)context_.scene->take_gone_meshes();
}

/// Gives the GPU scene clusters and levels of detail that are ready.
core::Expected<void> Drawing::follow_levels(core::Deadline deadline) {
  follow_meshes();
  if (!context_.renderer) return {};
  return context_.mesh_details.advance(*context_.scene, wants_levels(), deadline);
}

core::Expected<void> Drawing::finish_levels() {
  if (auto current = make_current(); !current) return current;
  if (auto done = follow_levels(core::deadline_in(0.0)); !done) return done;
  context_.mesh_details.wait();
  return follow_levels(core::kNoDeadline);
}

void Drawing::finish() {
  if (make_current()) queue_.finish();
}

// --- queries ---------------------------------------------------------------------------------------------------------

core::Expected<LeftOut> Drawing::left_out(const Culled& culled) {
  if (!context_.renderer) return LeftOut();
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  image_changed();
  (void)queue_.wait_for_room();
  return find_left_out(context_, overlays_, culled);
}

core::Expected<LossReport> Drawing::loss(const Culled& culled) {
  if (!context_.renderer) return LossReport();
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  return measure_loss(context_, culled);
}

std::optional<culling::GpuVariant> Drawing::gpu_variant() const {
  return culling_.culler() ? std::optional(culling_.culler()->variant()) : std::nullopt;
}

std::size_t Drawing::memory_bytes() const {
  std::size_t bytes = context_.scene->memory_bytes() + context_.lists->memory_bytes();
  bytes += upload_.memory_bytes() + culling_.memory_bytes() + overlays_.memory_bytes();
  if (!context_.renderer) return bytes;
  for (const auto& [number, image] : context_.images) bytes += image.memory_bytes();
  return bytes + context_.renderer->memory_bytes() + opaque_.memory_bytes();
}

}  // namespace sightline::engine
