// A model that is open: what is drawn of it, and from where.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sightline/analysis/query/colouring.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/view/attribute_list.h"
#include "sightline/apps/view/camera.h"
#include "sightline/apps/view/change_list.h"
#include "sightline/apps/view/document.h"
#include "sightline/apps/view/marking.h"
#include "sightline/apps/view/measuring.h"
#include "sightline/apps/view/model_facts.h"
#include "sightline/apps/view/model_tree.h"
#include "sightline/apps/view/revision_slider.h"
#include "sightline/apps/view/saved_session.h"
#include "sightline/apps/view/sections.h"
#include "sightline/apps/view/session_image.h"
#include "sightline/apps/view/tree_states.h"
#include "sightline/apps/viewpoints/item_names.h"
#include "sightline/apps/viewpoints/viewpoint.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/pick.h"

namespace sightline::apps {

class Session {
  Model model_;  // first: the others use its scene

 public:
  /// `config`: of the image; its lod_error is that of SessionImage::set_motion_error(). By any thread where the context
  /// comes later (begin()). The engine's tracer is then on its way, so that picks need not wait long.
  static core::Expected<std::unique_ptr<Session>> open(Model model, const engine::EngineConfig& config,
                                                       const engine::Engine::Progress& progress = {});
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  const Model& model() const { return model_; }
  const core::Scene& scene() const { return *model_.scene; }
  const core::dvec3& offset() const { return model_.offset; }
  /// Milliseconds of a frame, from begin() on, where no other budget is set and the culler is not one that uses the
  /// GPU; 0: none. The image at rest has all items.
  void set_default_budget(double ms) { default_budget_ms_ = ms; }
  /// Draws in that context, which is current, for the first time: all of the model, in an image of that size. In
  /// portions of about kPortion: to be called, with other work in between, until it returns true. Begins anew after a
  /// loss of the context.
  core::Expected<bool> begin(gl::Context& context, const std::array<int, 2>& size);
  /// The image that begin() will draw, by rays: while the context's programs are compiled. Null until it is there.
  const image::Image* first_image() const { return first_image_ ? &*first_image_ : nullptr; }
  /// Whether begin() has uploaded all of the model, and draws now or has drawn.
  bool uploaded() const { return uploaded_; }
  const core::FittedBounds& bounds() const { return bounds_; }
  /// Counted anew at the first call after items, or what is hidden, have changed.
  const TreeStates& tree_states();
  /// What is odd about the model.
  const std::vector<Finding>& findings();
  /// The items of a part, as views name it; none where the model has no such part.
  std::vector<core::ItemId> items_of(const PartName& part) { return names().find({false, {part}}).items; }

  /// Looks along a direction, or as the camera does, at all that is shown: Camera::show_all().
  void show_all(const std::optional<core::dvec3>& direction = {});

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
  /// Shows or hides what is in a state of the comparison.
  core::Expected<void> show_changes(compare::State state, bool shown);

  /// `edit` gives items of the scene other meshes, of the same shape, and tells whether it has.
  core::Expected<void> exchange_meshes(const std::function<bool(core::Scene&)>& edit);

  core::Expected<void> set_culler(engine::CullerChoice choice);

  std::vector<std::string> files;  ///< that were read
  Reading reading;                 ///< of these
  engine::Engine engine;
  Document document;
  ModelTree tree;
  AttributeList attributes;
  Measuring measuring;
  Marking marking;
  Sections sections;
  query::Colouring colouring;  ///< of the items: set by colour_by() alone; without groups where there is none
  Camera camera;
  RevisionSlider slider;  ///< moved by set_slider() alone
  SessionImage image;

 private:
  Session(Model model, engine::Engine made, const engine::EngineConfig& config);

  void fit_camera();
  void draw_first_image();
  double budget_in_use(double asked_for) const;
  const ItemNames& names() const;
  core::Expected<void> begin_slider();
  core::Expected<void> end_slider();
  core::Expected<void> edit_scene(const std::function<core::Expected<void>(core::Scene&)>& edit);

  mutable std::optional<ItemNames> names_;  // made when first asked for
  TreeStates tree_states_;
  std::optional<std::vector<Finding>> findings_;  // made when first asked for
  std::unique_ptr<ChangeList> changes_;
  core::FittedBounds bounds_;
  std::optional<image::Image> first_image_;
  double slider_budget_ms_ = 0.0;  // the budget without the slider
  bool uploaded_ = false;
  std::optional<double> budget_ms_;  // while begin() draws with another one
  double default_budget_ms_ = 0.0;
  double fitted_aspect_ = 0.0;  // for which begin() has fitted the camera
};

/// Gives items the colours of query::colour_by(), until another key or an empty one. Fails during a comparison, which
/// has colours of its own and ends these.
core::Expected<void> colour_by(Session& session, const std::string& key);

/// Selects what a row of the comparison names, and goes there.
core::Expected<void> go_to_change(Session& session, std::size_t row);

}  // namespace sightline::apps
