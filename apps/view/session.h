// A model that is open: what is drawn of it, and from where.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sightline/apps/common/model.h"
#include "sightline/apps/view/camera.h"
#include "sightline/apps/view/change_list.h"
#include "sightline/apps/view/document.h"
#include "sightline/apps/view/frozen_camera.h"
#include "sightline/apps/view/measuring.h"
#include "sightline/apps/view/model_facts.h"
#include "sightline/apps/view/model_tree.h"
#include "sightline/apps/view/resting_image.h"
#include "sightline/apps/view/sections.h"
#include "sightline/apps/view/tree_states.h"
#include "sightline/apps/viewpoints/item_names.h"
#include "sightline/apps/viewpoints/viewpoint.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/pick.h"

namespace sightline::apps {

class Session {
 public:
  /// `config`: of the image; its lod_error is that of set_motion_error(). By any thread where the context comes later
  /// (begin()). The engine's tracer is then on its way, so that picks need not wait long.
  static core::Expected<std::unique_ptr<Session>> open(Model model, const engine::EngineConfig& config,
                                                       const engine::Engine::Progress& progress = {});
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  const Model& model() const { return model_; }
  const core::Scene& scene() const { return *model_.scene; }
  const core::dvec3& offset() const { return model_.offset; }
  engine::Engine& engine() { return engine_; }
  const engine::Engine& engine() const { return engine_; }
  /// Milliseconds of a frame, from begin() on, where no other budget is set and the culler is not one that uses the
  /// GPU; 0: none. The image at rest has all items.
  void set_default_budget(double ms) { default_budget_ms_ = ms; }
  /// Draws in that context, which is current, for the first time: all of the model, in an image of that size. In
  /// portions of about kPortion: to be called, with other work in between, until it returns true. Begins anew after a
  /// loss of the context.
  core::Expected<bool> begin(gl::Context& context, const std::array<int, 2>& size);
  /// Whether begin() has uploaded all of the model, and draws now or has drawn.
  bool uploaded() const { return uploaded_; }
  /// Draws in that context from now on, which is current; a former one is lost. All else stays.
  core::Expected<void> use_context(gl::Context& context);
  Document& document() { return document_; }
  const Document& document() const { return document_; }
  Camera& camera() { return camera_; }
  const Camera& camera() const { return camera_; }
  ModelTree& tree() { return tree_; }
  const ModelTree& tree() const { return tree_; }
  Measuring& measuring() { return measuring_; }
  const Measuring& measuring() const { return measuring_; }
  const core::FittedBounds& bounds() const { return bounds_; }
  /// Counted anew at the first call after items, or what is hidden, have changed.
  const TreeStates& tree_states();
  /// What is odd about the model.
  const std::vector<Finding>& findings();
  /// The items of a part, as views name it; none where the model has no such part.
  std::vector<core::ItemId> items_of(const PartName& part) { return names().find({false, {part}}).items; }

  /// Looks along a direction, or as the camera does, at all that is shown: Camera::show_all().
  void show_all(const std::optional<core::dvec3>& direction = {});

  Sections& sections() { return sections_; }
  const Sections& sections() const { return sections_; }

  /// The view that the image shows now: the camera's, cut by the sections; `shift` as Camera::view() has it.
  core::Expected<core::View> view(const core::dvec2& shift = core::dvec2(0.0)) const;
  /// The view of another camera, of an image of any shape.
  core::Expected<core::View> view_of(const Camera& camera, double aspect,
                                     const core::dvec2& shift = core::dvec2(0.0)) const;
  double aspect() const { return double(size_[0]) / size_[1]; }
  const std::array<int, 2>& size() const { return size_; }
  core::Expected<void> resize(const std::array<int, 2>& size);
  /// Draws half as many pixels each way, or all of them again. Points of the image are those of all its pixels.
  core::Expected<void> set_coarse(bool coarse);
  bool coarse() const { return coarse_; }
  /// The image may be one of a view that moves, with fewer pixels or by levels of detail.
  bool lowered() const { return coarse_ || engine_.config().losses.lod_error > 0.0; }
  std::array<int, 2> drawn_size() const;  ///< that of the engine's image
  /// Pixels by which meshes may be drawn elsewhere, by levels of detail, while the view moves; 0: none. The levels are
  /// built in the background from begin() or this call on. Nothing where no item has a mesh or a GPU culls.
  core::Expected<void> set_motion_error(double pixels);
  bool has_levels() const;  ///< else that does nothing
  double motion_error() const { return motion_error_; }
  /// Draws meshes by levels of detail from now on, or again in full, and so anew where levels have drawn the image.
  core::Expected<void> set_moving(bool moving);

  /// Draws a frame unless it would be the last one again. True where it has drawn.
  core::Expected<bool> draw();
  /// Whether draw() would draw.
  bool stale() const;
  /// Makes the next draw() draw.
  void changed() {
    drawn_.reset();
    resting_.clear();
  }
  /// Draws one more of the images whose mean has smooth edges, or with a budget as much of it as that allows; nothing
  /// once they are complete, while the image is stale, or where multisampling leaves none to draw.
  core::Expected<void> refine();
  bool refining() const { return smooths() && !lowered() && !stale() && !resting_.complete(); }
  bool partly_refined() const { return resting_.count() > 0 && !resting_.complete(); }
  /// That mean; null until it is complete and while something has changed.
  const image::Image* smooth() const { return !stale() && resting_.complete() ? &mean_ : nullptr; }
  /// That mean, or with `smooth` false or where there is none the last frame's image, with all its pixels.
  core::Expected<image::Image> image(bool smooth);
  /// Draws a line around the item under the cursor, unless it is selected, over a framebuffer that shows the image.
  core::Expected<void> outline_hovered(const gl::ExternalTarget& target);
  const std::optional<core::View>& drawn() const { return drawn_; }  ///< the view of the image
  const engine::FrameReport& report() const { return report_; }
  std::int64_t visible() const { return visible_; }  ///< items in the view volume, as last known

  /// What the image shows at a point, pixels from its upper left corner.
  core::Expected<std::optional<engine::Pick>> pick(const core::dvec2& at);
  /// Engine::items_in() a rectangle of the image.
  core::Expected<std::vector<core::ItemId>> items_in(const engine::PixelRectangle& rectangle, culling::RegionRule rule);
  /// The feature that a point of the image is nearest to, within `reach` pixels, and its item.
  struct Aimed {
    core::ItemId item;
    measure::Snap snap;
  };
  core::Expected<std::optional<Aimed>> aim(const core::dvec2& at, double reach);
  /// That point in the world, or one as far away as the camera's target where nothing is, and while picks would wait.
  core::dvec3 point_at(const core::dvec2& at);

  /// What is seen and shown now, in the model's own frame; without a name.
  Viewpoint viewpoint() const;
  /// Shows that again. Returns how many of its parts this model does not have.
  core::Expected<std::size_t> show(const Viewpoint& viewpoint);

  /// Shows what has changed since an older revision, in place of another one, until end_comparison(). Meanwhile its
  /// removed items are part of the scene. Undo, and what is hidden and selected, go on through both.
  core::Expected<void> begin_comparison(std::unique_ptr<ChangeList> changes);
  core::Expected<void> end_comparison();
  ChangeList* changes() { return changes_.get(); }  ///< null while nothing is compared
  const ChangeList* changes() const { return changes_.get(); }
  /// Splits the image at a share of its width, 0 … 1: left of it is the older revision as it was, right of it the newer
  /// one, until it is set to none or the comparison ends. Meanwhile the scene has what the older revision had in place
  /// of moved and changed items, and there is no time budget. Needs a comparison.
  core::Expected<void> set_slider(std::optional<double> at);
  const std::optional<double>& slider() const { return slider_; }
  /// What the image has between two of its columns, which are drawn_size() in all.
  struct ImagePart {
    Revision revision = Revision::kNewer;
    int begin = 0, end = 0;
  };
  std::vector<ImagePart> parts() const;                              ///< from left to right; one without the slider
  core::Expected<std::uint32_t> framebuffer(const ImagePart& part);  ///< GL's name; it has all columns
  /// Shows or hides what is in a state of the comparison.
  core::Expected<void> show_changes(compare::State state, bool shown);
  /// Selects what a row of the comparison names, and goes there.
  core::Expected<void> go_to_change(std::size_t row);

  /// Puts the camera back to where it was before its last motions, each of which begins with remember().
  void camera_back();
  void remember();

  /// The culling camera that stays where it is; null where it is the image's.
  const FrozenCamera* frozen() const { return frozen_ ? &*frozen_ : nullptr; }
  /// Tells what the image lost by EngineConfig::losses. Nothing while it is stale, and while frozen().
  std::optional<engine::LossReport> loss();
  /// Culls for this view from now on, or again for the camera's.
  void set_frozen(bool frozen);
  core::Expected<void> set_culler(engine::CullerChoice choice);
  /// Engine::configure() with what `change` changes of the settings that hold.
  core::Expected<void> configure(const std::function<void(engine::EngineConfig&)>& change);

 private:
  Session(Model model, engine::Engine engine, const engine::EngineConfig& config);

  core::Expected<void> resize(const std::array<int, 2>& size, bool coarse);
  double budget_in_use(double asked_for) const;
  bool smooths() const { return engine_.config().drawing.samples == 1; }
  const ItemNames& names() const;
  core::Expected<engine::FrameReport> frame(const core::View& view);
  core::Expected<image::Image> read_image();
  core::Expected<void> begin_slider();
  core::Expected<void> end_slider();
  core::Expected<void> turn_to(Revision revision);
  core::Expected<void> turn_to(core::ItemId item);  // to a revision that has it
  core::Expected<void> turn_to_column(double x);    // to what size() has there
  core::Expected<void> edit_scene(const std::function<core::Expected<void>(core::Scene&)>& edit);

  Model model_;
  mutable std::optional<ItemNames> names_;  // made when first asked for
  engine::Engine engine_;
  Document document_;
  ModelTree tree_;
  TreeStates tree_states_;
  std::optional<std::vector<Finding>> findings_;  // made when first asked for
  Measuring measuring_;
  Sections sections_;
  std::unique_ptr<ChangeList> changes_;
  std::optional<double> slider_;
  Revision revision_ = Revision::kNewer;  // that the engine has
  double slider_budget_ms_ = 0.0;         // the budget without the slider
  core::FittedBounds bounds_;
  std::array<int, 2> size_;
  bool coarse_ = false;
  bool uploaded_ = false;
  std::optional<double> budget_ms_;  // while begin() draws with another one
  double default_budget_ms_ = 0.0;
  double motion_error_ = 0.0;
  Camera camera_;
  double fitted_aspect_ = 0.0;                       // for which begin() has fitted it
  std::vector<std::pair<core::Pose, bool>> places_;  // pose, orthographic
  std::optional<core::View> drawn_;
  std::optional<FrozenCamera> frozen_;
  std::optional<engine::LossReport> loss_;  // of drawn_, once it was asked for
  std::uint64_t drawn_version_ = 0;
  RestingImage resting_;
  image::Image mean_;
  engine::FrameReport report_;
  std::int64_t visible_ = 0;
};

}  // namespace sightline::apps
