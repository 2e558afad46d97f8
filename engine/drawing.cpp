#include "sightline/engine/internal/drawing.h"

#include <algorithm>
#include <array>
#include <utility>

#include "sightline/engine/internal/clock.h"
#include "sightline/engine/internal/item_sizes.h"
#include "sightline/gl/internal/program_cache.h"

namespace sightline::engine {
namespace {

constexpr std::size_t kFramesInFlight = 2;
constexpr GLuint64 kLongestFenceWait = 10'000'000'000;  // ns; a lost context must not hang the application
constexpr std::size_t kMostDrawn = 8;
constexpr core::Slot kAppendedPiece = 64;    // slots at a time, which may bring a mesh each
constexpr std::size_t kTouchedPiece = 1024;  // slots at a time
constexpr double kBudgetShare = 0.93;        // of a frame's budget, to draw in
constexpr double kPassShare = 0.5;           // of the time left, for the next pass: it may take longer than expected
constexpr double kLeastPasses = 2.0;         // that the time left must suffice for
constexpr double kSlower = 0.92;             // squares take what they took, or less by as much a frame
constexpr float kOverlooked = 0.125f;        // of the area that the last frame came to

}  // namespace

void Drawing::plan_programs(Plan& plan, const core::Snapshot& snapshot, bool draw) {
  std::array<std::size_t, gpuscene::kBatchKindCount> counts{};
  for (int kind = 0; kind < core::kKindCount; ++kind)
    counts[std::size_t(gpuscene::batch_of(core::Kind(kind)))] += snapshot.of_kind(core::Kind(kind)).size();
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

core::Expected<std::unique_ptr<Drawing>> Drawing::create(const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                                         const EngineConfig& config, const Overrides& overrides,
                                                         bool gpu_culls) {
  auto drawing = begin(config, overrides);
  if (!drawing) return drawing;
  [[maybe_unused]] const KeptState kept = (*drawing)->keep_state();
  if (auto done = (*drawing)->rebuild(snapshot, joints, gpu_culls); !done) return tl::unexpected(done.error());
  return drawing;
}

core::Expected<std::unique_ptr<Drawing>> Drawing::begin(const EngineConfig& config, const Overrides& overrides) {
  std::optional<gl::Context> own;
  if (!config.context) {
    gl::ContextOptions options;
    options.platform = config.context_platform;
    options.debug = config.gl_debug;
    auto made = gl::Context::create_offscreen(options);
    if (!made) return tl::unexpected(made.error());
    own = std::move(*made);
  }
  gl::Context context = (config.context ? *config.context : *own).share();
  std::unique_ptr<Drawing> drawing(new Drawing(std::move(own), std::move(context)));
  if (auto current = drawing->make_current(); !current) return tl::unexpected(current.error());
  drawing->gl_state_ = config.gl_state;
  [[maybe_unused]] const KeptState kept = drawing->keep_state();
  drawing->context_.cache_programs(config.program_cache.value_or(gl::ProgramCache::default_folder()));
  drawing->renders_ = config.draw;
  drawing->configure(config);
  drawing->translucent_ = TranslucentSlots(overrides, config.draw && config.transparency == Transparency::kBlended);
  drawing->cull_config_ = config.gpu_culler;
  if (config.draw) {
    auto target = render::RenderTarget::create(drawing->context_, config.width, config.height,
                                               {.ids = config.ids, .samples = config.samples});
    if (!target) return tl::unexpected(target.error());
    drawing->picture_->target = std::move(*target);
  }
  drawing->upload_.emplace();
  return drawing;
}

void Drawing::follow_later(std::span<const core::Slot> touched, std::span<const std::uint32_t> materials) {
  later_.touched.insert(later_.touched.end(), touched.begin(), touched.end());
  later_.came += touched.size();
  later_.materials.insert(later_.materials.end(), materials.begin(), materials.end());
}

/// In rising order, each once.
Drawing::Edits Drawing::take_later() {
  const auto settle = [](auto& list) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  };
  settle(later_.touched);
  settle(later_.materials);
  return std::exchange(later_, {});
}

void Drawing::configure(const EngineConfig& config) {
  sample_test_ = config.sample_test;
  occlusion_ = config.occlusion;
  budget_ms_ = config.budget_ms;
  hidden_colour_ = config.hidden_colour.value_or(core::vec3(0.0f));
  outline_colour_ = config.outline_colour;
  relief_ = config.relief;
  hatching_ = {config.hatching.strength, config.hatching.spacing};
  if (renderer_) renderer_->hatching = hatching_;
  if (upload_ && upload_->renderer) upload_->renderer->hatching = hatching_;
  set_contribution(config.contribution, config.contribution_way);
}

Drawing::~Drawing() {
  own_context_.reset();  // frees everything in it without changing which context is current
  (void)make_current();
  for (const InFlight& frame : in_flight_) context_.functions().DeleteSync(frame.fence);
}

Drawing::KeptState Drawing::keep_state() const {
  if (gl_state_ == GlState::kLeave) return {};
  if (own_context_) return keep_current();
  if (lost()) return {};
  return KeptState(std::in_place_type<gl::SavedState>, context_.functions());
}

bool Drawing::lost() const {
  (void)make_current();
  return context_.lost();
}

std::vector<std::string> Drawing::take_gl_errors() {
  return make_current() ? context_.take_errors() : std::vector<std::string>();
}

core::Expected<void> Drawing::rebuild(const core::Snapshot& snapshot, const gpuprims::Joints& joints, bool gpu_culls) {
  if (auto current = make_current(); !current) return current;
  upload_.reset();
  Upload upload;
  auto done = advance(upload, snapshot, joints, gpu_culls, core::kNoDeadline);
  if (!done) return tl::unexpected(done.error());
  for (auto& [number, picture] : pictures_) picture.passes.reset();
  if (auto taken = take(std::move(upload), snapshot); !taken) return taken;
  return leave_out_overlays(snapshot);
}

core::Expected<bool> Drawing::advance(Upload& upload, const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                      bool gpu_culls, core::Deadline deadline) {
  if (!upload.lists) {
    if (!upload.scene) {
      auto scene = gpuscene::GpuScene::begin(context_, snapshot, scene_ ? &*scene_ : nullptr);
      if (!scene) return tl::unexpected(scene.error());
      upload.scene = std::move(*scene);
    }
    if (!upload.uploaded) {
      const auto done = upload.scene->advance(snapshot, joints, deadline);
      if (!done || !*done) return done;
      upload.uploaded = true;
      upload.slots = core::Slot(snapshot.size());
    }
    if (const auto done = catch_up(upload, snapshot, joints, deadline); !done || !*done) return done;
    const Edits late = take_later();
    if (auto kept = upload.scene->update_materials(snapshot, late.materials); !kept)
      return tl::unexpected(kept.error());
    auto lists = gpuscene::DrawLists::create(context_, *upload.scene);
    if (!lists) return tl::unexpected(lists.error());
    upload.lists = std::move(*lists);
    if (gpu_culls) {
      auto culler = make_culler(snapshot, *upload.scene);
      if (!culler) return tl::unexpected(culler.error());
      upload.culler = std::move(*culler);
    }
    if (core::over(deadline)) return false;
  }
  if (!renders_ || renderer_) return true;
  if (!upload.renderer) {
    auto renderer = render::Renderer::begin(context_);
    if (!renderer) return tl::unexpected(renderer.error());
    upload.renderer = std::move(*renderer);
    upload.renderer->hatching = hatching_;
  }
  return upload.renderer->advance(*upload.scene, picture_->target.format(), deadline);
}

/// Makes a new scene follow the edits since it was begun. Whether it has followed all. Each call follows more than has
/// come since the last one, so that edits cannot keep it from ending.
core::Expected<bool> Drawing::catch_up(Upload& upload, const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                       core::Deadline deadline) {
  gpuscene::GpuScene& scene = *upload.scene;
  const auto slots = core::Slot(snapshot.size());
  core::Slot appended = 0, least = slots - std::exchange(upload.slots, slots) + kAppendedPiece;
  for (; !scene.has_all(snapshot); appended += kAppendedPiece) {
    if (appended >= least && core::over(deadline)) return false;
    if (auto done = scene.append(snapshot, joints, kAppendedPiece); !done) return done;
  }
  std::vector<core::Slot>& touched = later_.touched;
  std::size_t followed = 0, least_touched = std::exchange(later_.came, 0) + kTouchedPiece;
  for (; !touched.empty(); followed += kTouchedPiece) {
    if (followed >= least_touched && core::over(deadline)) return false;
    const std::size_t count = std::min(touched.size(), kTouchedPiece);
    std::vector<core::Slot> piece(touched.end() - std::ptrdiff_t(count), touched.end());
    touched.resize(touched.size() - count);
    std::sort(piece.begin(), piece.end());
    piece.erase(std::unique(piece.begin(), piece.end()), piece.end());
    scene.update(snapshot, piece, joints);
  }
  return true;
}

core::Expected<void> Drawing::take(Upload upload, const core::Snapshot& snapshot) {
  for (auto& [number, picture] : pictures_) picture.forget_slots();
  split_view_.reset();
  solid_areas_.reset();
  culler_ = std::move(upload.culler);
  scene_ = std::move(*upload.scene);
  lists_ = std::move(*upload.lists);
  if (upload.renderer) renderer_ = std::move(*upload.renderer);
  translucent_.reset(snapshot);
  return renderer_ ? renderer_->follow(*scene_, picture_->target.format()) : core::Expected<void>();
}

/// The culler does not find what is drawn over the picture. The scene must have all slots of the snapshot.
core::Expected<void> Drawing::leave_out_overlays(const core::Snapshot& snapshot) {
  if (!culler_ || !renders_) return {};
  const std::vector<core::Slot> slots = culling::slots_of(translucent_.bits());
  return slots.empty() ? core::Expected<void>() : culler_->update(snapshot, *scene_, slots, translucent_.bits());
}

core::Expected<bool> Drawing::advance_order(const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                            bool gpu_culls, core::Deadline deadline) {
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  if (!upload_) upload_.emplace();
  return advance(*upload_, snapshot, joints, gpu_culls, deadline);
}

core::Expected<void> Drawing::take_order(const core::Snapshot& former, const core::Snapshot& snapshot,
                                         const gpuprims::Joints& joints, bool gpu_culls) {
  if (auto current = make_current(); !current) return current;
  Upload upload = std::move(*upload_);
  upload_.reset();
  for (auto& [number, picture] : pictures_) picture.passes.follow(former, snapshot);
  if (auto done = take(std::move(upload), snapshot); !done) return done;
  const Edits late = take_later();
  if (auto done = update(snapshot, joints, late.touched, late.materials); !done) return done;
  if (gpu_culls && !culler_) return add_culler(snapshot);
  return leave_out_overlays(snapshot);
}

core::Expected<bool> Drawing::advance(const core::Snapshot& snapshot, const gpuprims::Joints& joints, bool gpu_culls,
                                      core::Deadline deadline) {
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  [[maybe_unused]] const KeptState kept = keep_state();
  if (upload_) {
    const auto done = advance(*upload_, snapshot, joints, gpu_culls, deadline);
    if (!done || !*done) return done;
    Upload upload = std::move(*upload_);
    upload_.reset();
    if (auto taken = take(std::move(upload), snapshot); !taken) return tl::unexpected(taken.error());
  }
  if (const auto done = warm_up(snapshot, deadline); !done || !*done) return done;
  const Edits late = take_later();
  auto done = update(snapshot, joints, late.touched, late.materials);
  if (done) done = leave_out_overlays(snapshot);
  return done.map([] { return true; });
}

core::Expected<bool> Drawing::warm_up(const core::Snapshot& snapshot, core::Deadline deadline) {
  while (renderer_ && warmed_up_ < scene_->batches().size()) {
    if (auto done = draw_one(snapshot, scene_->batches()[warmed_up_++]); !done) return tl::unexpected(done.error());
    if (core::over(deadline)) return false;
  }
  return (contribution_ <= 0.0f && budget_ms_ <= 0.0) || solid_areas_.measure(snapshot, deadline);
}

/// The first item that shows, from near.
core::Expected<void> Drawing::draw_one(const core::Snapshot& snapshot, const gpuscene::Batch& batch) {
  core::VisibleSet one;
  one.generation = snapshot.generation();
  std::vector<core::Slot> slots = gpuscene::GpuScene::slots_of(snapshot, batch.kind);
  slots.resize(batch.count);  // those that came later have no records yet
  const auto shows = [&](core::Slot slot) { return !snapshot.vacant(slot); };
  const auto first = std::find_if(slots.begin(), slots.end(), shows);
  if (first == slots.end()) return {};
  one.items = {*first};
  const core::Aabb box = snapshot.bounds().box(one.items[0]);
  const core::dvec3 origin = snapshot.bounds().origin;
  const auto view =
      core::View::fit({origin + core::dvec3(box.min), origin + core::dvec3(box.max)}, core::kOverviewDirection, 0.9,
                      double(picture_->target.width()) / picture_->target.height());
  if (!view) return {};
  if (auto done = lists_->update(snapshot, *scene_, one, &*view); !done) return done;
  if (auto done = renderer_->draw(*view, snapshot, *scene_, *lists_, picture_->target); !done) return done;
  if (relief_.any()) {
    if (!relief_pass_) relief_pass_.emplace(context_.functions());
    if (auto done = relief_pass_->draw(picture_->target, *view, relief_.shading, relief_.lines); !done) return done;
  }
  context_.functions().Finish();
  return {};
}

/// The first culler of a context measures which variant to use.
core::Expected<culling::GpuCuller> Drawing::make_culler(const core::Snapshot& snapshot,
                                                        const gpuscene::GpuScene& scene) {
  auto culler = culling::GpuCuller::create(context_, snapshot, scene, cull_config_);
  if (!culler) return culler;
  if (why_gpu_variant_.empty() || !cull_config_.variant) why_gpu_variant_ = culler->why_this_variant();
  if (culler->variant_settled()) cull_config_.variant = culler->variant();
  const bool occlusion = occlusion_ == OcclusionChoice::kOn && may_test_occlusion(*culler);
  if (auto done = culler->prepare(renders_ && (sample_test_ || occlusion), occlusion); !done)
    return tl::unexpected(done.error());
  return culler;
}

core::Expected<void> Drawing::add_culler(const core::Snapshot& snapshot) {
  if (culler_ || !scene_) return {};
  if (auto current = make_current(); !current) return current;
  auto culler = make_culler(snapshot, *scene_);
  if (!culler) return tl::unexpected(culler.error());
  culler_ = std::move(*culler);
  return leave_out_overlays(snapshot);
}

core::Expected<void> Drawing::resize(int width, int height) {
  if (auto current = make_current(); !current) return current;
  auto target = render::RenderTarget::create(context_, width, height, picture_->target.format());
  if (!target) return tl::unexpected(target.error());
  picture_->target = std::move(*target);
  picture_->refined.reset();
  picture_changed();
  return {};
}

core::Expected<void> Drawing::use_picture(std::uint32_t number, int width, int height) {
  const auto present = pictures_.find(number);
  const bool fits = present != pictures_.end() && present->second.target.width() == width &&
                    present->second.target.height() == height;
  if (!renders_ || (fits && picture_ == &present->second)) return {};
  if (!fits) {
    if (auto current = make_current(); !current) return current;
    auto target = render::RenderTarget::create(context_, width, height, picture_->target.format());
    if (!target) return tl::unexpected(target.error());
    pictures_[number] = {};
    pictures_[number].target = std::move(*target);
  }
  picture_ = &pictures_[number];
  split_view_.reset();
  return {};
}

/// Each of them: of what they have in common something else is to be seen.
void Drawing::pictures_changed() {
  for (auto& [number, picture] : pictures_) picture.changed();
  split_view_.reset();
}

core::Expected<void> Drawing::update(const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                     std::span<const core::Slot> touched, std::span<const std::uint32_t> materials) {
  if (auto current = make_current(); !current) return current;
  const auto larger = scene_->append(snapshot, joints);
  if (!larger) return rebuild(snapshot, joints, culler_.has_value());  // the scene is of no use then
  scene_->update(snapshot, touched, joints);
  if (*larger)
    if (auto done = follow_batches(snapshot); !done) return done;
  return follow_edit(snapshot, touched, materials, true);
}

/// Makes anew what is kept for each batch, where batches are larger or new.
core::Expected<void> Drawing::follow_batches(const core::Snapshot& snapshot) {
  auto lists = gpuscene::DrawLists::create(context_, *scene_);
  if (!lists) return tl::unexpected(lists.error());
  lists_ = std::move(*lists);
  if (renderer_)
    if (auto done = renderer_->follow(*scene_, picture_->target.format()); !done) return done;
  if (!std::exchange(culler_, std::nullopt)) return {};
  return add_culler(snapshot);
}

core::Expected<void> Drawing::update_looks(const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                           std::span<const core::Slot> touched,
                                           std::span<const std::uint32_t> materials) {
  if (auto current = make_current(); !current) return current;
  scene_->update_looks(snapshot, touched, joints);
  return follow_edit(snapshot, touched, materials, false);
}

core::Expected<void> Drawing::follow_edit(const core::Snapshot& snapshot, std::span<const core::Slot> touched,
                                          std::span<const std::uint32_t> materials, bool moved) {
  pictures_changed();
  if (auto done = scene_->update_materials(snapshot, materials); !done) return done;
  solid_areas_.update(snapshot, touched);
  const std::vector<core::Slot> turned = translucent_.update(snapshot, touched, materials);
  if (!culler_) return {};
  const culling::SlotBits left_out = renders_ ? translucent_.bits() : culling::SlotBits();
  auto done = moved ? culler_->update(snapshot, *scene_, touched, left_out)
                    : culler_->update_shown(snapshot, *scene_, touched, left_out);
  if (done && !turned.empty()) done = culler_->update_shown(snapshot, *scene_, turned, left_out);
  return done;
}

void Drawing::wait_for_room() {
  const double begin = now_seconds();
  while (in_flight_.size() >= kFramesInFlight) wait_for_oldest();
  waited_ms_ = 1e3 * (now_seconds() - begin);
}

void Drawing::wait_for_oldest() {
  const gl::Functions& gl = context_.functions();
  const InFlight oldest = in_flight_.front();
  in_flight_.pop_front();
  const bool ready = gl.ClientWaitSync(oldest.fence, GL_SYNC_FLUSH_COMMANDS_BIT, 0) == GL_ALREADY_SIGNALED;
  if (!ready) gl.ClientWaitSync(oldest.fence, GL_SYNC_FLUSH_COMMANDS_BIT, kLongestFenceWait);
  gl.DeleteSync(oldest.fence);
  const double now = now_seconds();
  drawn_.push_back({oldest.frame, ready ? 0.0 : 1e3 * (now - std::max(last_drawn_, oldest.submitted))});
  if (drawn_.size() > kMostDrawn) drawn_.pop_front();  // not taken by anybody
  last_drawn_ = now;
}

core::Expected<void> Drawing::draw(const Culled& culled, std::uint64_t frame, double began, bool all) {
  waited_ms_ = 0.0;
  all_visible_ = all;
  if (!renderer_) return {};
  if (auto current = make_current(); !current) return current;
  if (split_view_) picture_changed();
  wait_for_room();
  if (auto done = draw_visible(culled, began); !done) return done;
  return submit(frame);
}

core::Expected<void> Drawing::draw_visible(const Culled& culled, double began) {
  const core::VisibleSet& solid = has_overlays() ? part_overlays(culled.visible) : culled.visible;
  if (auto done = draw_solid(culled.with(solid), began); !done) return done;
  return finish_picture(culled);
}

core::Expected<void> Drawing::draw_solid(const Culled& culled, double began) {
  depth_known_ = picture_->kept = false;
  if (budget_ms_ > 0.0) {
    const double deadline = began + kBudgetShare * 1e-3 * budget_ms_;
    return draw_in_budget(culled, deadline);
  }
  const core::VisibleSet& large = leave_out_small(culled, contribution_);
  const std::int64_t count = std::int64_t(culled.snapshot.count(large));
  const OcclusionWay way = occlusion_way(culled.with(large), count);
  const bool tested = way != OcclusionWay::kOff;
  if (tested) {
    const bool rehearses = &large == &culled.visible && may_rehearse(culled);
    const auto draw_tested = [&] { return rehearses ? draw_rehearsed(culled) : draw_in_passes(culled.with(large)); };
    const bool measures = way == OcclusionWay::kOnBesidePart;
    if (auto done = measures ? measure_ways(culled.with(large), draw_tested) : draw_tested(); !done) return done;
  } else {
    picture_->passes.reset();
    if (auto done = draw_at_once(culled.with(large)); !done) return done;
  }
  counts_.small = &large == &culled.visible ? 0 : std::int64_t(culled.snapshot.count(culled.visible)) - count;
  if (counts_.small == 0 || contribution_way_ == ContributionWay::kDrop) return {};
  const bool stochastic = contribution_way_ == ContributionWay::kStochastic;
  return draw_squares(culled, picture_->was_large, stochastic ? contribution_ : 0.0f, tested);
}

culling::ContributionTest Drawing::contribution_test(const core::View& view, const core::Snapshot& snapshot) {
  return {view, snapshot.bounds().origin, picture_->target.width(), picture_->target.height(),
          solid_areas_.of(snapshot)};
}

core::Expected<void> Drawing::draw_from_aside(const core::View& view, const Culled& culled, std::uint64_t frame,
                                              double began) {
  waited_ms_ = 0.0;
  all_visible_ = false;
  if (auto current = make_current(); !current) return current;
  wait_for_room();
  const core::VisibleSet& solid = has_overlays() ? part_overlays(culled.visible) : culled.visible;
  if (auto done = split(culled.with(solid)); !done) return done;
  const auto seen = [&](const core::VisibleSet& set) {
    return Culled{view, culled.snapshot, set, culled.lines, culled.hierarchy};
  };
  if (auto done = draw_solid(seen(shown_), began); !done) return done;
  if (auto done = draw_hidden(view, culled.snapshot); !done) return done;
  if (auto done = finish_picture(seen(culled.visible)); !done) return done;
  return submit(frame);
}

/// Once for all frames of one view that was culled for: its picture is drawn for the distances, and what they hide is
/// not shown.
core::Expected<void> Drawing::split(const Culled& culled) {
  const auto& [view, snapshot, visible, lines, hierarchy] = culled;
  if (split_view_ && core::same_picture(*split_view_, view)) return {};
  picture_changed();
  const core::ItemBounds& bounds = snapshot.bounds();
  if (may_test_occlusion()) {
    if (auto done = draw_in_passes(culled); !done) return done;
    occlusion_test(view, bounds.origin).filter(bounds, visible, shown_, lines);
  } else if (sample_test_) {
    culling::SampleTest(view, bounds.origin, samples()).filter(bounds, visible, shown_, lines);
  } else {
    shown_ = visible;
  }
  std::vector<std::uint64_t> shown(culling::bit_words(bounds.size()));
  culling::set_bits(shown_, shown);
  hidden_.clear();
  hidden_.generation = shown_.generation = visible.generation;
  visible.for_each_slot([&](core::Slot slot) {
    if (!bounds.vacant(slot) && !culling::contains(shown, slot)) hidden_.items.push_back(slot);
  });
  std::sort(hidden_.items.begin(), hidden_.items.end());
  if (auto done = make_hidden_materials(snapshot); !done) return done;
  split_view_ = view;
  return {};
}

core::Expected<void> Drawing::make_hidden_materials(const core::Snapshot& snapshot) {
  const gl::Functions& gl = context_.functions();
  const std::vector<glm::vec4> rows(snapshot.materials().size() + 1, glm::vec4(hidden_colour_, 1.0f));
  auto buffer = gl::Buffer::create(gl, std::span(rows), 0, "colour of hidden items");
  if (!buffer) return tl::unexpected(buffer.error());
  auto texels = gl::TextureBuffer::create(gl, *buffer, GL_RGBA32F, "colour of hidden items");
  if (!texels) return tl::unexpected(texels.error());
  hidden_materials_ = std::move(*texels);
  hidden_rows_ = std::move(*buffer);
  return {};
}

/// Beside what is drawn of the same view, which may hide most of them.
core::Expected<void> Drawing::draw_hidden(const core::View& view, const core::Snapshot& snapshot) {
  const core::ItemBounds& bounds = snapshot.bounds();
  const core::VisibleSet* left = &hidden_;
  if (may_test_occlusion()) {
    read_back_depth(view, picture_->target);
    occlusion_test(view, bounds.origin).filter(bounds, hidden_, sampled_);
    left = &sampled_;
  }
  counts_.shown += std::int64_t(snapshot.count(*left));
  if (auto done = lists_->update(snapshot, *scene_, *left, &view); !done) return done;
  return renderer_->draw_more(view, snapshot, *scene_, *lists_, picture_->target, &hidden_materials_);
}

/// The part of the visible set that contributes enough to the picture.
const core::VisibleSet& Drawing::leave_out_small(const Culled& culled, float threshold) {
  const auto& [view, snapshot, visible, lines, hierarchy] = culled;
  if (threshold <= 0.0f) return visible;
  const core::ItemBounds& bounds = snapshot.bounds();
  const culling::ContributionTest test = contribution_test(view, snapshot);
  const core::VisibleSet* candidates = &visible;
  if (hierarchy) {
    test.filter_leaves(*hierarchy, visible, threshold, large_leaves_, lines);
    candidates = &large_leaves_;
  }
  test.filter(bounds, *candidates, threshold, large_, picture_->was_large, lines);
  picture_->was_large.assign(culling::bit_words(bounds.size()), 0);
  culling::set_bits(large_, picture_->was_large);
  return large_;
}

core::Expected<void> Drawing::draw_squares(const Culled& culled, culling::SlotBits without, float least_area,
                                           bool distances_known) {
  const culling::OcclusionTest occlusion = occlusion_test(culled.view, culled.snapshot.bounds().origin);
  const SmallItems::Known known =
      distances_known ? SmallItems::Known{picture_->distances, &occlusion} : SmallItems::Known{};
  auto done = small_items_.draw(context_, culled, contribution_test(culled.view, culled.snapshot), without, least_area,
                                known, *scene_, picture_->target, threads_);
  counts_.squares = std::int64_t(small_items_.drawn());
  return done;
}

void Drawing::set_contribution(float pixels, ContributionWay way) {
  if (pixels != contribution_)
    for (auto& [number, picture] : pictures_) picture.was_large.clear();
  pictures_changed();
  contribution_ = pixels;
  contribution_way_ = way;
}

/// Between passes the depth is read back, which stalls a GPU, but is a copy in memory on a software rasteriser; frames
/// that are rehearsed need none of it. Few items are not worth it.
OcclusionWay Drawing::occlusion_way(const Culled& candidates, std::int64_t count) {
  if (!may_test_occlusion()) return OcclusionWay::kOff;
  if (occlusion_ == OcclusionChoice::kOn) return OcclusionWay::kOn;
  if (count < std::int64_t(software() ? kSmallOcclusionScene : kSmallOcclusionSceneForGpu)) return OcclusionWay::kOff;
  return occlusion_switch_.use(
      mean_area(candidates.view, candidates.snapshot.bounds(), candidates.visible, picture_->target.height()));
}

namespace {

/// Every `parts`-th block of the slots, `part` the first of them.
core::VisibleSet part_of(const core::VisibleSet& visible, core::Slot parts, core::Slot part) {
  core::VisibleSet some;
  some.generation = visible.generation;
  for (const core::Slot slot : visible.items)
    if (slot / core::kBlockSlots % parts == part) some.items.push_back(slot);
  for (const core::SlotRange& range : visible.ranges) {
    const core::Slot end = range.first + range.count, from = range.first / core::kBlockSlots;
    for (core::Slot block = from + (part + parts - from % parts) % parts; block * core::kBlockSlots < end;
         block += parts) {
      const core::Slot first = std::max(range.first, block * core::kBlockSlots);
      some.ranges.push_back({first, std::min(end, (block + 1) * core::kBlockSlots) - first});
    }
  }
  return some;
}

}  // namespace

/// Draws with the test, and then some of the candidates again, as a frame without it would all: see OcclusionWay. That
/// changes no pixel, since what is there already has them all in front.
core::Expected<void> Drawing::measure_ways(const Culled& culled,
                                           const std::function<core::Expected<void>()>& draw_tested) {
  const auto& [view, snapshot, visible, lines, hierarchy] = culled;
  const auto took_ms = [&](const auto& draw) -> core::Expected<double> {
    const double began = now_seconds();
    if (auto done = draw(); !done) return tl::unexpected(done.error());
    context_.functions().Finish();
    return 1e3 * (now_seconds() - began);
  };
  context_.functions().Finish();
  const auto tested_ms = took_ms(draw_tested);
  if (!tested_ms) return tl::unexpected(tested_ms.error());
  constexpr auto kParts = core::Slot(1.0 / OcclusionSwitch::kTriedPart);
  part_ = (part_ + 1) % kParts;
  const core::VisibleSet part = part_of(visible, kParts, part_);
  const auto part_ms = took_ms([&] {
    culling::SampleTest(view, snapshot.bounds().origin, samples()).filter(snapshot.bounds(), part, sampled_, lines);
    return draw_pass(view, snapshot, sampled_, picture_->target);
  });
  if (!part_ms) return tl::unexpected(part_ms.error());
  occlusion_switch_.measured(*tested_ms, *part_ms);
  return {};
}

culling::PictureSamples Drawing::samples() const {
  culling::PictureSamples samples{picture_->target.width(), picture_->target.height(), {}, snap()};
  for (const glm::vec2& offset : picture_->target.sample_offsets()) samples.offsets.push_back({offset.x, offset.y});
  return samples;
}

float Drawing::snap() const {
  return culling::rasteriser_snap(context_.capabilities().subpixel_bits, picture_->target.width(),
                                  picture_->target.height());
}

/// Against what read_back_depth() has read.
culling::OcclusionTest Drawing::occlusion_test(const core::View& view, const core::dvec3& origin) const {
  return {view,
          origin,
          picture_->target.width(),
          picture_->target.height(),
          picture_->pyramid,
          render::RenderTarget::orthographic_error(view),
          snap()};
}

void Drawing::read_back_depth(const core::View& view, const render::RenderTarget& target) {
  target.read_distances(view, picture_->distances);
  picture_->pyramid.build(picture_->distances, picture_->target.width(), picture_->target.height());
}

core::Expected<void> Drawing::draw_at_once(const Culled& culled) {
  const auto& [view, snapshot, visible, lines, hierarchy] = culled;
  if (sample_test_)
    culling::SampleTest(view, snapshot.bounds().origin, samples()).filter(snapshot.bounds(), visible, sampled_, lines);
  const core::VisibleSet& shown = sample_test_ ? sampled_ : visible;
  const auto drawn = std::int64_t(snapshot.count(shown));
  counts_ = {drawn, drawn};
  if (auto done = lists_->update(snapshot, *scene_, shown, &view); !done) return done;
  return renderer_->draw(view, snapshot, *scene_, *lists_, picture_->target);
}

/// The occlusion test rejects what covers no pixel centre, too.
core::Expected<void> Drawing::draw_in_passes(const Culled& culled) {
  const auto& [view, snapshot, visible, lines, hierarchy] = culled;
  const core::ItemBounds& bounds = snapshot.bounds();
  const culling::OcclusionTest test = occlusion_test(view, bounds.origin);
  picture_->pyramid.clear(picture_->target.width(), picture_->target.height());
  picture_->passes.begin(visible, lines, hierarchy, threads_);
  renderer_->clear(picture_->target);
  while (picture_->passes.next(test, bounds)) {
    if (auto done = draw_pass(view, snapshot, picture_->passes.pass(), picture_->target); !done) return done;
    read_back_depth(view, picture_->target);
  }
  picture_->passes.remember(test, bounds);
  counts_ = {-1, std::int64_t(picture_->passes.drawn())};
  depth_known_ = true;
  return {};
}

core::Expected<void> Drawing::draw_pass(const core::View& view, const core::Snapshot& snapshot,
                                        const core::VisibleSet& pass, const render::RenderTarget& target) {
  if (auto done = lists_->update(snapshot, *scene_, pass, &view); !done) return done;
  return renderer_->draw_more(view, snapshot, *scene_, *lists_, target);
}

/// Candidates far smaller than what the last frame came to are not even measured while the view moves. The first frame
/// of a view that stays begins anew with all of them, the next ones go on. With squares they do so beside the picture,
/// which gets a copy and the squares of what is not in it yet.
core::Expected<void> Drawing::draw_in_budget(const Culled& culled, double deadline) {
  const auto& [view, snapshot, visible, lines, hierarchy] = culled;
  const core::ItemBounds& bounds = snapshot.bounds();
  const bool stays = picture_->budget_view && core::same_picture(*picture_->budget_view, view),
             goes_on = stays && picture_->refines;
  const bool tests = may_test_occlusion();
  const bool beside = stays && (contribution_way_ != ContributionWay::kDrop || changes_picture());
  if (goes_on && picture_->budget.complete()) {
    picture_->kept = true;
    counts_.shown = std::int64_t(picture_->budget.drawn());
    return {};
  }
  if (beside && !picture_->refined) {
    auto made = render::RenderTarget::create(context_, picture_->target.width(), picture_->target.height(),
                                             picture_->target.format());
    if (!made) return tl::unexpected(made.error());
    picture_->refined = std::move(*made);
  }
  const render::RenderTarget& canvas = beside ? *picture_->refined : picture_->target;
  const culling::OcclusionTest test = occlusion_test(view, bounds.origin);
  if (!goes_on) {
    const float threshold =
        stays ? contribution_ : std::max(contribution_, kOverlooked * picture_->budget.largest_pending());
    picture_->pyramid.clear(picture_->target.width(), picture_->target.height());
    const core::VisibleSet& candidates = leave_out_small(culled, threshold);
    const auto left_out = std::int64_t(snapshot.count(visible) - snapshot.count(candidates));
    picture_->overlooked = threshold > contribution_ ? left_out : 0;
    counts_.small = left_out - picture_->overlooked;
    picture_->budget.begin(contribution_test(view, snapshot), bounds, candidates, lines);
    picture_->refines = stays;
    picture_->budget_view = view;
    renderer_->clear(canvas);
  }
  for (int passes = 0; !picture_->budget.complete(); ++passes) {
    double left = 1e3 * (deadline - now_seconds());
    if (picture_->budget.pending_ms() > left) left -= squares_ms_;
    if (passes > 0 && left < kLeastPasses * picture_->budget.least_ms()) break;
    if (!picture_->budget.next(tests ? &test : nullptr, bounds, kPassShare * left)) break;
    const double begin = now_seconds();
    if (auto done = draw_pass(view, snapshot, picture_->budget.pass(), canvas); !done) return done;
    if (tests) {
      read_back_depth(view, canvas);
    } else {
      context_.functions().Finish();
    }
    picture_->budget.took(1e3 * (now_seconds() - begin));
  }
  if (tests && !goes_on) picture_->budget.remember(test, bounds, &threads_);
  counts_ = {-1, std::int64_t(picture_->budget.drawn()), counts_.small,
             std::int64_t(picture_->budget.pending()) + picture_->overlooked};
  const double begin = now_seconds();
  if (beside) picture_->refined->copy_to(picture_->target);
  if (contribution_way_ == ContributionWay::kDrop) return {};
  core::Expected<void> done;
  if (counts_.pending + counts_.small > 0) {
    picture_->budget.looked_at(bounds.size(), without_squares_);
    done = draw_squares(culled, without_squares_, 0.0f, tests && picture_->budget.drawn() > 0);
  }
  context_.functions().Finish();
  squares_ms_ = std::max(1e3 * (now_seconds() - begin), kSlower * squares_ms_);
  return done;
}

core::Expected<void> Drawing::cull(const core::View& cull_view, const core::View& view, const core::Snapshot& snapshot,
                                   std::uint64_t frame) {
  if (auto current = make_current(); !current) return current;
  culled_picture_.reset();
  const bool occlusion = tests_occlusion_on_gpu(snapshot.size());
  if (renderer_ && (sample_test_ || occlusion)) culled_picture_ = {view, samples(), occlusion};
  return culler_->cull(cull_view, snapshot, *scene_, *lists_, frame, culled_picture_ ? &*culled_picture_ : nullptr);
}

bool Drawing::may_test_occlusion(const culling::GpuCuller& culler) const {
  return renders_ && picture_->target.format().samples == 1 && culler.can_test_occlusion();
}

bool Drawing::tests_occlusion_on_gpu(std::size_t items) const {
  if (occlusion_ == OcclusionChoice::kOff || !may_test_occlusion(*culler_)) return false;
  return occlusion_ == OcclusionChoice::kOn || items >= kGpuOcclusionScene;
}

core::Expected<void> Drawing::draw_culled(const core::View& view, const core::Snapshot& snapshot, std::uint64_t frame,
                                          const Culled* visible) {
  if (auto current = make_current(); !current) return current;
  picture_changed();
  wait_for_room();
  if (renderer_) {
    auto done = renderer_->draw(view, snapshot, *scene_, *lists_, picture_->target);
    if (done && culled_picture_ && culled_picture_->occlusion) done = draw_others(snapshot);
    depth_known_ = picture_->kept = false;
    if (done && visible) (void)part_overlays(visible->visible);
    const core::VisibleSet none;
    if (done) done = finish_picture(visible ? *visible : Culled{view, snapshot, none, {}, nullptr});
    if (!done) return done;
  }
  return submit(frame);
}

/// The second pass of a frame that the GPU culls: what the first has not drawn and does not hide.
core::Expected<void> Drawing::draw_others(const core::Snapshot& snapshot) {
  const core::View& view = culled_picture_->view;
  const double error = render::RenderTarget::orthographic_error(view);
  if (auto done = culler_->cull_others(*culled_picture_, *scene_, *lists_, picture_->target.depth(), error); !done)
    return done;
  return renderer_->draw_more(view, snapshot, *scene_, *lists_, picture_->target);
}

std::optional<Drawing::Drawn> Drawing::take_drawn() {
  if (drawn_.empty()) return std::nullopt;
  const Drawn oldest = drawn_.front();
  drawn_.pop_front();
  return oldest;
}

std::optional<culling::GpuCuller::Feedback> Drawing::take_gpu_feedback() {
  if (!culler_ || !make_current()) return std::nullopt;
  return culler_->take_feedback();
}

core::Expected<void> Drawing::compose() {
  if (!compositor_) compositor_.emplace(context_.functions());
  return compositor_->draw(picture_->target, *external_, renderer_->background);
}

core::Expected<void> Drawing::submit(std::uint64_t frame) {
  if (external_ && !picture_->composed)
    if (auto done = compose(); !done) return done;
  const gl::Functions& gl = context_.functions();
  in_flight_.push_back({gl.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0), frame, now_seconds()});
  gl.Flush();
  return {};
}

void Drawing::finish() {
  if (!make_current()) return;
  while (!in_flight_.empty()) wait_for_oldest();
}

std::size_t Drawing::memory_bytes() const {
  std::size_t bytes = scene_->memory_bytes() + lists_->memory_bytes();
  if (upload_ && upload_->scene) bytes += upload_->scene->memory_bytes();
  if (upload_ && upload_->lists) bytes += upload_->lists->memory_bytes();
  if (upload_ && upload_->culler) bytes += upload_->culler->memory_bytes();
  if (culler_) bytes += culler_->memory_bytes();
  if (renderer_)
    for (const auto& [number, picture] : pictures_) bytes += picture.memory_bytes();
  if (overlays_) bytes += overlays_->memory_bytes();
  if (renderer_) bytes += renderer_->memory_bytes() + small_items_.memory_bytes();
  return bytes;
}

}  // namespace sightline::engine
