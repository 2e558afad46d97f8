// The half of an engine that needs GL: context, GPU scene, draw lists, GPU culler, renderer and target. Only in builds
// with GL.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <variant>

#include "sightline/core/internal/deadline.h"
#include "sightline/culling/contribution.h"
#include "sightline/culling/gpu/internal/gpu_culler.h"
#include "sightline/culling/sample_test.h"
#include "sightline/culling/solid_occluders.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/internal/culled.h"
#include "sightline/engine/internal/occlusion_switch.h"
#include "sightline/engine/internal/picture_state.h"
#include "sightline/engine/internal/small_items.h"
#include "sightline/engine/internal/solid_areas.h"
#include "sightline/engine/internal/translucent.h"
#include "sightline/gl/internal/current_context.h"
#include "sightline/gl/internal/saved_state.h"
#include "sightline/render/internal/compositor.h"
#include "sightline/render/internal/overlays.h"
#include "sightline/render/internal/relief_pass.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::engine {

/// Functions that need the context make it current on the calling thread, unless it was adopted, and leave it current:
/// KeptState is for their callers.
class Drawing {
 public:
  /// `overrides` are borrowed.
  static core::Expected<std::unique_ptr<Drawing>> create(const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                                         const EngineConfig& config, const Overrides& overrides,
                                                         bool gpu_culls);
  /// The same in portions: begin(), and advance() until it returns true. Each call of it does at least a little, and
  /// ends a few milliseconds after the deadline, but for single programs, meshes and the GPU culler. It also draws an
  /// item of each batch, since some drivers compile when a program first draws, and does once what the first frame
  /// otherwise does. Meanwhile resize(), configure(), follow_later() and lost() may be called. Items in another order
  /// need another Drawing. It is of no use after a failure.
  static core::Expected<std::unique_ptr<Drawing>> begin(const EngineConfig& config, const Overrides& overrides);
  core::Expected<bool> advance(const core::Snapshot& snapshot, const gpuprims::Joints& joints, bool gpu_culls,
                               core::Deadline deadline);
  /// As update(), of the snapshot that advance() or advance_order() works on.
  void follow_later(std::span<const core::Slot> touched, std::span<const std::uint32_t> materials);
  /// Makes what another order of the items needs, in portions as advance(), while frames show the present one. Once
  /// advance_order() has returned true, take_order() shows the other one. abandon_order() forgets it.
  core::Expected<bool> advance_order(const core::Snapshot& snapshot, const gpuprims::Joints& joints, bool gpu_culls,
                                     core::Deadline deadline);
  core::Expected<void> take_order(const core::Snapshot& former, const core::Snapshot& snapshot,
                                  const gpuprims::Joints& joints, bool gpu_culls);
  void abandon_order() {
    upload_.reset();
    later_ = {};
  }
  ~Drawing();
  /// Sets the plan's entry for the program of each batch kind.
  static void plan_programs(Plan& plan, const core::Snapshot& snapshot, bool draw);

  /// While it lives, what the application has may change. With a context of the engine's own that is which context is
  /// current, and in the application's context its state (EngineConfig::gl_state), unless that is lost.
  using KeptState = std::variant<std::monostate, gl::CurrentContext, gl::SavedState>;
  static KeptState keep_current() { return KeptState(std::in_place_type<gl::CurrentContext>); }
  KeptState keep_state() const;

  /// From now on each frame puts its picture into that framebuffer, too; null: into none. The size must be that of the
  /// picture.
  void put_into(const core::ExternalTarget* target) {
    external_ = target ? std::optional(*target) : std::nullopt;
    picture_->composed = false;
  }

  /// Whether any items are drawn over the picture. The CPU finds those that are visible, also where the GPU culls,
  /// which leaves out translucent ones.
  bool has_overlays() const { return renders_ && !(translucent_.bits().empty() && translucent_.outlined().empty()); }
  /// Whether some of that may be blended.
  bool blends() const { return renders_ && !translucent_.bits().empty(); }
  /// Eye depths between which the blended items of a set lie.
  glm::vec2 blend_range(const core::View& view, const core::Snapshot& snapshot, const core::VisibleSet& visible);
  /// From the next draw() on they weigh by these depths; none: by those of what it is given.
  void set_blend_range(const std::optional<glm::vec2>& range) { blend_range_ = range; }

  /// Submits one frame that shows a visible set, without items that cover no sample of the picture (SampleTest) or that
  /// others hide (OcclusionTest). Waits first until at most one earlier frame is still being drawn. take_drawn()
  /// returns `frame`. `began`: when the frame's budget began to run, seconds on the steady clock. Does nothing when
  /// there is nothing to render. `all`: whether the set has all that is visible in its view, and not in another one.
  core::Expected<void> draw(const Culled& culled, std::uint64_t frame, double began = 0.0, bool all = false);
  /// The same, but seen in `view`. What the two rules leave out of the picture of the view that was culled for is drawn
  /// in EngineConfig::hidden_colour, and needs no budget.
  core::Expected<void> draw_from_aside(const core::View& view, const Culled& culled, std::uint64_t frame, double began);
  /// Of the last draw().
  struct Counts {
    std::int64_t sampled = 0, shown = 0;  // items that may cover a sample, -1 with the occlusion test; items drawn
    std::int64_t small = 0;               // items below the contribution that is asked for
    std::int64_t pending = 0;             // items that the budget did not suffice for
    std::int64_t squares = 0;             // of the small ones, drawn as one square
  };
  const Counts& counts() const { return counts_; }
  /// Draws an outline of the visible items of `items` over a framebuffer: Engine::draw_outline(). The picture stays.
  core::Expected<void> put_outline(const Culled& items, const core::ExternalTarget& over);
  /// What a picture of the view would leave out of what is visible. Draws it for the distances, so that the last
  /// picture is gone. No history: the contribution's threshold has no hysteresis.
  core::Expected<LeftOut> left_out(const Culled& culled);
  /// What contribution and budget have left out of the last draw(), which must have shown that.
  core::Expected<LossReport> loss(const Culled& culled);
  /// The next draw() shows something else, though its view may be that of the last one: a budget begins anew.
  void picture_changed() {
    picture_->changed();
    split_view_.reset();
  }
  /// From now on all is about that picture: Engine::use_picture(). It is made unless there is one of that size.
  core::Expected<void> use_picture(std::uint32_t number, int width, int height);
  void forget_picture(std::uint32_t number) { pictures_.erase(number); }
  /// From the next draw() on: what Engine::configure() may change.
  void configure(const EngineConfig& config);
  /// Of these, EngineConfig::contribution and contribution_way alone.
  void set_contribution(float pixels, ContributionWay way);

  /// cull() culls by `cull_view` on the GPU for a picture of `view`, and draw_culled() submits a frame of the result.
  /// Both need the GPU culler. take_gpu_feedback() returns `frame`, too.
  core::Expected<void> cull(const core::View& cull_view, const core::View& view, const core::Snapshot& snapshot,
                            std::uint64_t frame);
  /// `visible`: where there are overlays.
  core::Expected<void> draw_culled(const core::View& view, const core::Snapshot& snapshot, std::uint64_t frame,
                                   const Culled* visible = nullptr);
  /// How long the last call of these functions has waited, milliseconds.
  double waited_ms() const { return waited_ms_; }
  /// A frame that is drawn, with the time that the GPU spent on it alone. That time runs from the end of the frame
  /// before, or from the submission of this one if that is later, until its end. It is measured by waiting for the end;
  /// 0: there was no wait. take_drawn() returns the oldest frame not yet taken.
  struct Drawn {
    std::uint64_t frame = 0;
    double gpu_ms = 0.0;
  };
  std::optional<Drawn> take_drawn();
  std::optional<culling::GpuCuller::Feedback> take_gpu_feedback();
  /// Follows an edit of `touched` slots (Snapshot::apply) and of materials (SceneDelta::materials). Rewrites their
  /// records and adds the records of appended slots, with their meshes and kinds.
  core::Expected<void> update(const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                              std::span<const core::Slot> touched, std::span<const std::uint32_t> materials);
  /// The same where placements and shapes are as they were, and no slots were appended.
  core::Expected<void> update_looks(const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                    std::span<const core::Slot> touched, std::span<const std::uint32_t> materials);
  /// Makes everything anew from another snapshot, with or without a GPU culler.
  core::Expected<void> rebuild(const core::Snapshot& snapshot, const gpuprims::Joints& joints, bool gpu_culls);
  /// Makes the GPU culler unless there is one. `snapshot` must be that of the last update() or rebuild().
  core::Expected<void> add_culler(const core::Snapshot& snapshot);
  /// See Engine::resize.
  core::Expected<void> resize(int width, int height);
  void finish();

  const gl::Context& context() const { return context_; }
  core::Expected<void> make_current() const { return context_.make_current(); }
  /// Whether the context is lost, see gl::Context::lost.
  bool lost() const;
  const std::string& platform() const { return context_.platform(); }
  const std::string& renderer() const { return context_.renderer(); }
  bool software() const { return context_.capabilities().software; }
  const culling::GpuCuller* gpu_culler() const { return culler_ ? &*culler_ : nullptr; }
  /// Variant of the GPU culler; none without one.
  std::optional<culling::GpuVariant> gpu_variant() const {
    return culler_ ? std::optional(culler_->variant()) : std::nullopt;
  }
  const std::string& why_gpu_variant() const { return why_gpu_variant_; }
  const gpuscene::GpuScene& scene() const { return *scene_; }
  const gpuscene::DrawLists& lists() const { return *lists_; }
  std::vector<std::string> take_gl_errors();
  const render::RenderTarget& target() const { return picture_->target; }
  std::size_t memory_bytes() const;

 private:
  /// As update() takes them, in rising order.
  struct Edits {
    std::vector<core::Slot> touched;
    std::vector<std::uint32_t> materials;
    std::size_t came = 0;  // touched since catch_up() last looked
  };
  /// What is made for one order of the items, in this order; culler and renderer only where they are needed. The
  /// renderer serves all orders.
  struct Upload {
    std::optional<gpuscene::GpuScene> scene;
    bool uploaded = false;                     // as it was when it was begun
    core::Slot slots = 0;                      // of the snapshot, when catch_up() last looked
    std::optional<gpuscene::DrawLists> lists;  // none: the scene is not complete
    std::optional<culling::GpuCuller> culler;
    std::optional<render::Renderer> renderer;
  };

  Drawing(std::optional<gl::Context> own, gl::Context context)
      : context_(std::move(context)), own_context_(std::move(own)) {}
  core::Expected<bool> advance(Upload& upload, const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                               bool gpu_culls, core::Deadline deadline);
  core::Expected<void> take(Upload upload, const core::Snapshot& snapshot);
  core::Expected<bool> catch_up(Upload& upload, const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                core::Deadline deadline);
  core::Expected<void> leave_out_overlays(const core::Snapshot& snapshot);
  Edits take_later();
  core::Expected<bool> warm_up(const core::Snapshot& snapshot, core::Deadline deadline);
  core::Expected<void> draw_one(const core::Snapshot& snapshot, const gpuscene::Batch& batch);
  core::Expected<culling::GpuCuller> make_culler(const core::Snapshot& snapshot, const gpuscene::GpuScene& scene);
  core::Expected<void> follow_batches(const core::Snapshot& snapshot);
  void pictures_changed();
  core::Expected<void> follow_edit(const core::Snapshot& snapshot, std::span<const core::Slot> touched,
                                   std::span<const std::uint32_t> materials, bool moved);
  void wait_for_room();
  void wait_for_oldest();
  float snap() const;
  culling::PictureSamples samples() const;
  culling::OcclusionTest occlusion_test(const core::View& view, const core::dvec3& origin) const;
  void read_back_depth(const core::View& view, const render::RenderTarget& target);
  bool may_test_occlusion() const {
    return occlusion_ != OcclusionChoice::kOff && picture_->target.format().samples == 1;
  }
  OcclusionWay occlusion_way(const Culled& candidates, std::int64_t count);
  bool may_test_occlusion(const culling::GpuCuller& culler) const;
  bool tests_occlusion_on_gpu(std::size_t items) const;
  core::Expected<void> draw_others(const core::Snapshot& snapshot);
  core::Expected<void> draw_visible(const Culled& culled, double began);
  core::Expected<void> draw_solid(const Culled& culled, double began);
  const core::VisibleSet& part_overlays(const core::VisibleSet& visible);
  /// Whether the complete picture is changed, so that nothing more can be drawn to it.
  bool changes_picture() const { return renders_ && (relief_.any() || has_overlays()); }
  core::Expected<void> finish_picture(const Culled& culled);
  core::Expected<void> draw_overlays(const Culled& culled);
  core::Expected<void> draw_translucent(const Culled& culled);
  core::Expected<void> draw_outline(const Culled& culled);
  core::Expected<render::PixelBox> draw_outlined(const Culled& items);
  core::Expected<void> put_over(const std::function<core::Expected<void>(const core::ExternalTarget&)>& put) const;
  const core::VisibleSet& worth_drawing(const Culled& culled);
  core::Expected<void> split(const Culled& culled);
  core::Expected<void> make_hidden_materials(const core::Snapshot& snapshot);
  core::Expected<void> draw_hidden(const core::View& view, const core::Snapshot& snapshot);
  core::Expected<void> measure_ways(const Culled& culled, const std::function<core::Expected<void>()>& draw_tested);
  core::Expected<void> draw_at_once(const Culled& culled);
  core::Expected<void> draw_in_passes(const Culled& culled);
  bool may_rehearse(const Culled& culled);
  core::Expected<void> draw_rehearsed(const Culled& culled);
  core::Expected<void> draw_open(const Culled& culled, const culling::OcclusionTest& test);
  void find_open(const Culled& culled, const culling::OcclusionTest& test, core::VisibleSet& set,
                 const std::function<void()>& beside);
  core::Expected<void> draw_solids(const Culled& culled, const core::VisibleSet& open);
  core::Expected<void> draw_unsolid(const Culled& culled);
  core::Expected<void> draw_in_budget(const Culled& culled, double deadline);
  core::Expected<void> draw_pass(const core::View& view, const core::Snapshot& snapshot, const core::VisibleSet& pass,
                                 const render::RenderTarget& target);
  culling::ContributionTest contribution_test(const core::View& view, const core::Snapshot& snapshot);
  const core::VisibleSet& leave_out_small(const Culled& culled, float threshold);
  core::Expected<void> draw_squares(const Culled& culled, culling::SlotBits without, float least_area,
                                    bool distances_known);
  core::Expected<void> submit(std::uint64_t frame);
  core::Expected<void> compose();

  struct InFlight {
    GLsync fence;
    std::uint64_t frame;
    double submitted;  // seconds on the steady clock
  };

  gl::Context context_;                     // shared: everything below is made with it and must be destroyed before it
  std::optional<gl::Context> own_context_;  // none when the context is the application's
  GlState gl_state_ = GlState::kRestore;
  bool renders_ = true;
  culling::GpuCullerConfig cull_config_;  // names the variant once it is known
  std::string why_gpu_variant_;
  std::optional<Upload> upload_;  // of the first order, or of another one beside scene_
  Edits later_;                   // that it has not followed yet
  std::size_t warmed_up_ = 0;     // batches of which advance() has drawn an item
  std::optional<gpuscene::GpuScene> scene_;
  std::optional<gpuscene::DrawLists> lists_;
  bool sample_test_ = true;
  OcclusionChoice occlusion_ = OcclusionChoice::kAutomatic;
  float contribution_ = 0.0f;
  double budget_ms_ = 0.0;
  std::vector<std::uint64_t> without_squares_;  // a bit per slot, with a budget
  double squares_ms_ = 0.0;                     // that copying and squares of a frame with a budget take
  ContributionWay contribution_way_ = ContributionWay::kDrop;
  SmallItems small_items_;
  SolidAreas solid_areas_;
  core::vec3 hidden_colour_{0.0f};
  Relief relief_;
  glm::vec2 hatching_{0.0f};                       // Renderer::hatching
  std::optional<render::ReliefPass> relief_pass_;  // made with the first relief
  std::optional<core::View> split_view_;           // what its picture shows, and what the tests leave out of it
  core::VisibleSet shown_, hidden_;
  gl::Buffer hidden_rows_;
  gl::TextureBuffer hidden_materials_;  // one colour for all
  core::VisibleSet sampled_, large_, large_leaves_;
  culling::SolidOccluders solids_;
  core::VisibleSet unsolid_;      // of a rehearsed frame, drawn before it
  core::VisibleSet open_, left_;  // open in the end; of these, drawn then
  std::vector<core::Slot> at_near_plane_;
  culling::CullThreads threads_;  // for the occlusion test; none begins before the first large set
  OcclusionSwitch occlusion_switch_;
  core::Slot part_ = 0;  // of the frame that measured last
  Counts counts_;
  std::optional<culling::GpuCuller> culler_;
  std::optional<culling::GpuCuller::Picture>
      culled_picture_;                        // of the last cull(); none where all of the view is drawn
  std::optional<render::Renderer> renderer_;  // none when the engine only culls
  std::map<std::uint32_t, PictureState> pictures_;
  PictureState* picture_ = &pictures_[0];  // of these, the one in use
  TranslucentSlots translucent_;
  std::optional<render::Overlays> overlays_;                   // made with the first
  core::VisibleSet solid_, over_, blended_, ghosts_, unused_;  // parts of what is visible
  std::optional<glm::vec2> blend_range_;
  core::VisibleSet outlined_, tested_;
  core::vec3 outline_colour_{0.0f};
  bool all_visible_ = false;  // is in the set to draw
  bool depth_known_ = false;  // picture_->pyramid is of the picture, or nowhere nearer
  std::optional<core::ExternalTarget> external_;
  std::optional<render::Compositor> compositor_;  // made with the first external target
  std::deque<InFlight> in_flight_;
  std::deque<Drawn> drawn_;
  double last_drawn_ = 0.0, waited_ms_ = 0.0;  // seconds: when the newest of drawn_ was known to be drawn
};

}  // namespace sightline::engine
