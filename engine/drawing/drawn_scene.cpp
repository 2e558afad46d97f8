#include "sightline/engine/drawing/internal/drawn_scene.h"

#include <algorithm>
#include <array>
#include <utility>

#include "sightline/core/internal/store.h"
#include "sightline/engine/drawing/internal/warm_up.h"
#include "sightline/gl/internal/current_context.h"
#include "sightline/gl/internal/saved_state.h"

namespace sightline::engine {
namespace {

constexpr int kWarmUpSize = 64;  // pixels a side, of images that are drawn to make the driver compile

struct KeptCurrentContext : KeptState {
  gl::CurrentContext context;
};
struct KeptContextState : KeptState {
  explicit KeptContextState(const gl::Functions& gl) : state(gl) {}
  gl::SavedState state;
};

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

std::unique_ptr<KeptState> keep_current_context() {
  return std::make_unique<KeptCurrentContext>();
}

void plan_programs(Plan& plan, const core::Snapshot& snapshot, bool draw, const char* why_not) {
  const auto counts = count_batches(snapshot);
  for (int i = 0; i < gpuscene::kBatchKindCount; ++i) {
    const auto batch = gpuscene::BatchKind(i);
    const std::size_t n = counts[std::size_t(i)];
    std::string feature(gpuscene::name_of(batch));
    std::replace(feature.begin(), feature.end(), '_', ' ');
    feature += gpuscene::is_ray_cast(batch) ? " program (ray-cast)" : " program";
    const std::string why = !draw ? why_not : n > 0 ? count_text(n) : "none in the scene";
    set_entry(plan, {std::move(feature), draw && n > 0, why});
  }
}

DrawnScene::DrawnScene(std::optional<gl::Context> own, gl::Context shared, const EngineConfig& config,
                       const Overrides& overrides)
    : context_(std::move(shared), config),
      own_context_(std::move(own)),
      overlays_(TranslucentSlots(overrides, config.draw && config.drawing.transparency == Transparency::kBlended)) {}

std::unique_ptr<KeptState> DrawnScene::keep_state() const {
  if (context_.config.context.gl_state == GlState::kLeave) return nullptr;
  if (own_context_) return keep_current_context();
  return lost() ? nullptr : std::make_unique<KeptContextState>(context_.gl());
}

bool DrawnScene::lost() const {
  (void)make_current();
  return context_.context.lost();
}

core::Expected<render::RenderTarget> DrawnScene::make_target(int width, int height) const {
  return render::RenderTarget::create(context_.context, width, height, context_.target().format());
}

/// The next frame shows something else, though its view may be that of the last one: a budget begins anew.
void DrawnScene::image_changed() {
  context_.image->changed();
  unseen_.reset();
}

void DrawnScene::images_changed() {
  for (auto& [number, image] : context_.images) image.changed();
  unseen_.reset();
}

// --- scene versions -------------------------------------------------------------------------------------------------

core::Expected<bool> DrawnScene::advance(const core::Snapshot& snapshot, const gpuprims::Joints& joints, bool gpu_culls,
                                         core::Deadline deadline) {
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  const auto kept = keep_state();
  if (upload_.active()) {
    const auto done = upload_.advance(context_, culling_, snapshot, joints, gpu_culls, deadline);
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

core::Expected<bool> DrawnScene::advance_version(const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                                 bool gpu_culls, core::Deadline deadline) {
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  if (!upload_.active()) upload_.begin();
  return upload_.advance(context_, culling_, snapshot, joints, gpu_culls, deadline);
}

core::Expected<void> DrawnScene::take_version(const core::Snapshot& former, const core::Snapshot& snapshot,
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

core::Expected<void> DrawnScene::rebuild(const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                         bool gpu_culls) {
  if (auto current = make_current(); !current) return current;
  upload_.begin();
  if (context_.config.draw && own_context_ && !context_.renderer)
    engine::warm_up(context_.context, context_.config, context_.target().format(), batches_of(snapshot));
  if (auto done = upload_.advance(context_, culling_, snapshot, joints, gpu_culls, core::kNoDeadline); !done) {
    upload_.abandon();
    return tl::unexpected(done.error());
  }
  for (auto& [number, image] : context_.images) image.passes.reset();
  if (auto taken = take_upload(snapshot); !taken) return taken;
  context_.mesh_details.keep_only(*context_.scene, wants_levels());
  return culling_.leave_out(context_, snapshot, overlaid());
}

/// Draws what the upload has made from now on.
core::Expected<void> DrawnScene::take_upload(const core::Snapshot& snapshot) {
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

core::Expected<void> DrawnScene::add_culler(const core::Snapshot& snapshot) {
  if (culling_.culler() || !context_.scene) return {};
  if (auto current = make_current(); !current) return current;
  auto culler = culling_.make(context_, snapshot, *context_.scene);
  if (!culler) return tl::unexpected(culler.error());
  culling_.use(std::move(*culler));
  return culling_.leave_out(context_, snapshot, overlaid());
}

core::Expected<bool> DrawnScene::warm_up(const core::Snapshot& snapshot, core::Deadline deadline) {
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
core::Expected<void> DrawnScene::draw_one(const core::Snapshot& snapshot, const gpuscene::Batch& batch) {
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
  auto done = context_.clear(context_.target());
  const Frame frame{*view, *view, snapshot};
  if (done) done = context_.draw(frame, {one, context_.target()});
  if (done) done = overlays_.draw_looks(context_, frame, one);
  context_.image->pyramid_valid = false;  // it would be that of the small image
  if (!done) return done;
  context_.gl().Finish();
  return {};
}

// --- edits -----------------------------------------------------------------------------------------------------------

core::Expected<void> DrawnScene::update(Edit edit, const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                        std::span<const core::Slot> touched, std::span<const std::uint32_t> materials,
                                        core::Deadline deadline) {
  if (auto current = make_current(); !current) return current;
  if (edit == Edit::kStyles) {
    context_.scene->update_styles(snapshot, touched, joints);
    return follow_edit(edit, snapshot, touched, materials);
  }
  const auto larger = context_.scene->follow(snapshot, joints, touched, deadline);
  if (!larger) return rebuild(snapshot, joints, culling_.culler());  // the scene is of no use then
  follow_meshes();
  if (*larger)
    if (auto done = follow_batches(snapshot); !done) return done;
  return follow_edit(edit, snapshot, touched, materials);
}

core::Expected<bool> DrawnScene::upload_meshes(core::Deadline deadline) {
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  images_changed();
  return context_.scene->upload_meshes(deadline);
}

/// Makes anew what is kept for each batch, where batches are larger or new.
core::Expected<void> DrawnScene::follow_batches(const core::Snapshot& snapshot) {
  if (auto done = core::store(gpuscene::DrawLists::create(context_.context, *context_.scene), context_.lists); !done)
    return done;
  if (context_.renderer)
    if (auto done = context_.renderer->follow(*context_.scene, context_.target().format()); !done) return done;
  if (!culling_.culler()) return {};
  culling_.use(std::nullopt);
  return add_culler(snapshot);
}

core::Expected<void> DrawnScene::follow_edit(Edit edit, const core::Snapshot& snapshot,
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

/// Learns which meshes have come and gone, and gives back memory where they have become far fewer.
void DrawnScene::follow_meshes() {
  if (std::exchange(packs_, context_.scene->meshes().packs()) < packs_) context_.lists->trim();
  if (context_.renderer) return context_.mesh_details.follow(*context_.scene, wants_levels());
  (void)context_.scene->meshes().take_new_meshes(core::kNone);  // nobody else will, and their lists would grow
  (void)context_.scene->meshes().take_gone_meshes();
}

/// Gives the GPU scene clusters and levels of detail that are ready.
core::Expected<void> DrawnScene::follow_levels(core::Deadline deadline) {
  follow_meshes();
  if (!context_.renderer) return {};
  return context_.mesh_details.advance(*context_.scene, wants_levels(), deadline);
}

core::Expected<void> DrawnScene::finish_levels() {
  if (auto current = make_current(); !current) return current;
  if (auto done = follow_levels(core::deadline_in(0.0)); !done) return done;
  context_.mesh_details.wait();
  return follow_levels(core::kNoDeadline);
}

}  // namespace sightline::engine
