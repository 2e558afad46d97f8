#include "sightline/apps/view/session.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/apps/view/opening_steps.h"
#include "sightline/core/image_rays.h"
#include "sightline/core/internal/sort_unique.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::apps {
namespace {

/// Whether a budget would rule out what was chosen.
bool may_use_gpu(engine::CullerChoice choice) {
  return choice == engine::CullerChoice::kGpu || choice == engine::CullerChoice::kHybrid;
}

}  // namespace

core::Expected<std::unique_ptr<Session>> Session::open(Model model, const engine::EngineConfig& config,
                                                       const engine::Engine::Progress& progress) {
  engine::EngineConfig exact = config;
  exact.losses.lod_error = 0.0;
  auto engine = engine::Engine::create(*model.scene, exact, progress);
  if (!engine) return tl::unexpected(engine.error());
  engine->prepare_picks();
  return std::unique_ptr<Session>(new Session(std::move(model), std::move(*engine), config));
}

Session::Session(Model model, engine::Engine made, const engine::EngineConfig& config)
    : model_(std::move(model)),
      engine(std::move(made)),
      document(*model_.scene, engine),
      tree(*model_.scene),
      attributes(*model_.scene),
      camera(engine.snapshot().bounds().fitted_bounds().bounds, kFovy, double(config.width) / config.height),
      slider(engine, document),
      image(engine, document, camera, sections, slider, config.losses.lod_error),
      bounds_(engine.snapshot().bounds().fitted_bounds()) {}

void Session::show_all(const std::optional<core::dvec3>& direction) {
  const core::ItemBounds& items = engine.snapshot().bounds();
  if (direction)
    camera.show_all(items, *direction, image.aspect(), sections.planes());
  else
    camera.show_all(items, image.aspect(), sections.planes());
}

core::Expected<bool> Session::begin(gl::Context& context, const std::array<int, 2>& size) {
  if (!budget_ms_) {
    engine::EngineConfig config = engine.config();
    budget_ms_ = config.losses.budget_ms;
    config.losses.budget_ms = 1e3 * kPortion;
    (void)engine.configure(config);  // it cannot while the GPU must cull: then the first image is drawn at once
  }
  if (auto done = image.resize(size); !done) return tl::unexpected(done.error());
  uploaded_ = !engine.renderer().empty();
  if (!uploaded_) {
    draw_first_image();
    return engine.use_context(context, kPortion).map([this](bool done) {
      uploaded_ = done;
      return false;
    });
  }
  fit_camera();
  if (const auto drawn = image.draw(); !drawn) return engine.renderer().empty() ? core::Expected<bool>(false) : drawn;
  if (image.report().pending > 0) return false;
  first_image_.reset();
  engine::EngineConfig config = engine.config();
  config.losses.budget_ms = budget_in_use(*std::exchange(budget_ms_, std::nullopt));
  config.losses.lod_error = image.has_levels() ? image.motion_error() : 0.0;  // so that levels are built from now on
  if (auto done = engine.configure(config); !done) return tl::unexpected(done.error());
  return true;
}

/// Not in each portion: it takes a tenth of a second for a million items.
void Session::fit_camera() {
  if (fitted_aspect_ == image.aspect()) return;
  fitted_aspect_ = image.aspect();
  camera = Camera(bounds_.bounds, kFovy, fitted_aspect_);
  show_all(core::kOverviewDirection);
}

/// Draws it in the size that the window's image has now. Where rays cannot, the window shows the model later.
void Session::draw_first_image() {
  const std::array<int, 2> size = image.drawn_size();
  const bool fits = first_image_ && first_image_->width == size[0] && first_image_->height == size[1];
  if (fits || engine.preparing_picks()) return;
  fit_camera();
  if (image.draw())
    if (auto read = engine.read_colour()) first_image_ = std::move(*read);
  image.changed();
}

double Session::budget_in_use(double asked_for) const {
  return asked_for > 0.0 || may_use_gpu(engine.config().culling.culler) ? asked_for : default_budget_ms_;
}

core::Expected<std::optional<engine::Pick>> Session::pick(const core::dvec2& at) {
  const auto seen = image.view();
  const auto ray =
      seen ? core::image_ray(*seen, image.size()[0], image.size()[1], at.x, at.y) : tl::unexpected(seen.error());
  if (!ray) return tl::unexpected(ray.error());
  if (auto done = slider.turn_to_column(at.x, image.size()[0], image.drawn_size()); !done)
    return tl::unexpected(done.error());
  return engine.pick(*ray, raytrace::filter_of(*seen));
}

core::Expected<std::vector<core::ItemId>> Session::items_in(const engine::PixelRectangle& rectangle,
                                                            culling::RegionRule rule) {
  const auto seen = image.view();
  if (!seen) return tl::unexpected(seen.error());
  const std::array<int, 2> drawn = image.drawn_size(), size = image.size();
  const double x = double(drawn[0]) / size[0], y = double(drawn[1]) / size[1];
  std::vector<core::ItemId> items;
  for (const ImagePart& part : slider.parts(drawn[0])) {
    engine::PixelRectangle own{x * rectangle.x0, y * rectangle.y0, x * rectangle.x1, y * rectangle.y1};
    if (part.begin > 0) own.x0 = std::max(own.x0, double(part.begin));
    if (part.end < drawn[0]) own.x1 = std::min(own.x1, double(part.end));
    if (slider.at() && own.x0 >= own.x1) continue;
    if (auto done = slider.at() ? slider.turn_to(part.revision, drawn) : core::Expected<void>(); !done)
      return tl::unexpected(done.error());
    const auto found = engine.items_in(*seen, own, rule);
    if (!found) return found;
    items.insert(items.end(), found->begin(), found->end());
  }
  core::sort_unique(items);
  return items;
}

core::Expected<std::optional<Session::Aimed>> Session::aim(const core::dvec2& at, double reach) {
  const auto seen = image.view();
  if (!seen) return tl::unexpected(seen.error());
  const auto hit = pick(at);
  if (!hit) return tl::unexpected(hit.error());
  const auto ray = core::image_ray(*seen, image.size()[0], image.size()[1], at.x, at.y);
  if (!*hit || !ray) return std::nullopt;
  const auto item = measure::Item::create(scene(), (*hit)->item);
  if (!item) return tl::unexpected(item.error());
  const double per_pixel = 2.0 * std::tan(0.5 * camera.fovy()) / image.size()[1];  // at the distance of one metre
  measure::Aim aim{(*hit)->point, 0.0, measure::AimRay{ray->origin, ray->direction, 0.0}};
  if (camera.orthographic())
    aim.radius = reach * per_pixel * glm::length(camera.pose().target - camera.pose().eye);
  else
    aim.ray->slope = reach * per_pixel;
  const auto snap = measure::snap(*item, aim, seen->sections, seen->section_mode);
  if (!snap) return std::nullopt;
  return Aimed{(*hit)->item, *snap};
}

core::dvec3 Session::point_at(const core::dvec2& at) {
  const core::Pose& pose = camera.pose();
  const auto seen = image.view();
  if (!seen) return pose.target;
  if (!engine.preparing_picks())
    if (const auto hit = pick(at); hit && *hit) return (*hit)->point;
  const core::dvec3 ahead = glm::normalize(pose.target - pose.eye);
  const auto ray = core::image_ray(*seen, image.size()[0], image.size()[1], at.x, at.y);
  const double along = ray ? glm::dot(ray->direction, ahead) : 0.0;
  if (!(along > 0.0)) return pose.target;
  return ray->origin + ray->direction * (glm::dot(pose.target - ray->origin, ahead) / along);
}

const ItemNames& Session::names() const {
  if (!names_) names_.emplace(scene());
  return *names_;
}

const TreeStates& Session::tree_states() {
  tree_states_.follow(tree.rows(), scene(), document);
  return tree_states_;
}

const std::vector<Finding>& Session::findings() {
  if (!findings_) findings_ = sightline::apps::findings(scene(), bounds_);
  return *findings_;
}

Viewpoint Session::viewpoint() const {
  Viewpoint seen;
  seen.pose = camera.pose();
  seen.fovy = camera.fovy();
  seen.orthographic = camera.orthographic();
  seen.near = camera.near();
  seen.sections = sections.planes();
  seen.measurements = measuring.list();
  seen.markups = marking.list();
  seen.colour_by = colouring.key;
  seen.shown.emplace();
  if (document.hidden() > 0) seen.shown->hidden = names().name(document.items_with(Document::kHidden), true);
  if (document.ghosts() > 0) seen.shown->ghosts = names().name(document.items_with(Document::kGhost), false);
  if (!document.selection().empty()) seen.shown->selection = names().name(document.selection(), false);
  return translated(seen, -offset());
}

core::Expected<std::size_t> Session::show(const Viewpoint& viewpoint) {
  Viewpoint there = translated(viewpoint, offset());
  if (!there.has_target && !there.orthographic) {
    // As far ahead as the middle of the model, which motions then turn about.
    const core::dvec3 ahead = glm::normalize(there.pose.target - there.pose.eye);
    const core::dvec3 middle = bounds_.bounds.empty() ? ahead : bounds_.bounds.centre() - there.pose.eye;
    const double least = 1e-2 * (bounds_.bounds.empty() ? 1.0 : glm::length(bounds_.bounds.size()));
    there.pose.target = there.pose.eye + ahead * std::max({least, 1e-6, glm::dot(middle, ahead)});
  }
  camera.remember();
  camera.set_pose(there.pose);
  camera.set_fovy(there.fovy);
  camera.set_orthographic(there.orthographic);
  if (!there.orthographic && there.near > 0.0) camera.set_planes(there.near, core::kInfiniteFar);
  sections.set(there.sections, bounds_.bounds);
  measuring.merge(there.measurements);
  marking.set(std::move(there.markups));
  // A view that was kept of another model may have a key that this one lacks: its own colours are shown then.
  if (!changes_ && there.colour_by && *there.colour_by != colouring.key && !apps::colour_by(*this, *there.colour_by))
    if (auto done = apps::colour_by(*this, {}); !done) return tl::unexpected(done.error());
  if (!there.shown) return 0;
  const Viewpoint::Shown& shown = *there.shown;
  const auto hidden = names().find(shown.hidden), ghosts = names().find(shown.ghosts),
             selected = names().find(shown.selection);
  if (auto done = document.set(hidden.items, ghosts.items, selected.items); !done) return tl::unexpected(done.error());
  return hidden.missing + ghosts.missing + selected.missing;
}

/// All that depends on the scene follows, whether the edit fails or not.
core::Expected<void> Session::edit_scene(const std::function<core::Expected<void>(core::Scene&)>& edit) {
  tree.release_scene();
  auto done = edit(*model_.scene);
  const auto committed = engine.commit();
  document.follow_scene();
  tree.follow_scene();
  attributes.follow_scene();
  names_.reset();
  findings_.reset();
  bounds_ = engine.snapshot().bounds().fitted_bounds();
  image.changed();
  return done ? committed : done;
}

core::Expected<void> Session::exchange_meshes(const std::function<bool(core::Scene&)>& edit) {
  tree.release_scene();
  if (!edit(*model_.scene)) return {};
  image.changed();
  return engine.commit();
}

core::Expected<void> Session::begin_comparison(std::unique_ptr<ChangeList> changes) {
  if (auto ended = end_comparison(); !ended) return ended;
  colouring = {};
  changes_ = std::move(changes);
  auto done = edit_scene([&](core::Scene& scene) { return changes_->add_removed(scene); });
  if (done) done = document.set_base_styles(changes_->base_styles());
  if (done) return done;
  if (const auto ended = end_comparison(); !ended) return ended;
  return done;
}

core::Expected<void> Session::end_comparison() {
  if (!changes_) return {};
  if (auto done = set_slider({}); !done) return done;
  auto done = document.set_base_styles({});
  const auto edited = edit_scene([&](core::Scene& scene) -> core::Expected<void> {
    changes_->take_removed(scene);
    return {};
  });
  changes_.reset();
  return done ? edited : done;
}

core::Expected<void> Session::set_slider(std::optional<double> at) {
  if (!at) return slider.at() ? end_slider() : core::Expected<void>();
  if (!slider.at())
    if (auto done = begin_slider(); !done) return done;
  slider.set(*at, *changes_);
  document.hovered.reset();  // something else may lie below the cursor now

  // It has other parts, and has left the images of the engine shifted.
  if (image.begun_refining()) image.changed();
  return {};
}

core::Expected<void> Session::begin_slider() {
  slider.set(0.0, *changes_);
  auto done = edit_scene([&](core::Scene& scene) { return changes_->add_replaced(scene); });
  if (done) done = document.set_base_styles(changes_->base_styles());
  if (done)
    done = image.configure([this](engine::EngineConfig& config) {
      slider_budget_ms_ = std::exchange(config.losses.budget_ms, 0.0);  // it would begin anew with each revision
    });
  if (done) return done;
  if (const auto ended = end_slider(); !ended) return ended;
  return done;
}

/// All of it, whether a step fails or not.
core::Expected<void> Session::end_slider() {
  auto done = slider.end(image.drawn_size());
  const auto also = [&done](const core::Expected<void>& step) {
    if (done) done = step;
  };
  also(edit_scene([&](core::Scene& scene) -> core::Expected<void> {
    changes_->take_replaced(scene);
    return {};
  }));
  also(document.set_base_styles(changes_->base_styles()));
  also(image.configure([this](engine::EngineConfig& config) { config.losses.budget_ms = slider_budget_ms_; }));
  return done;
}

core::Expected<void> Session::show_changes(compare::State state, bool shown) {
  changes_->set_shown(state, shown);
  if (auto done = document.set_base_styles(changes_->base_styles()); !done) return done;
  const std::vector<core::ItemId> selection(document.selection().begin(), document.selection().end());
  return document.select(selection);  // but for those that are no longer seen
}

core::Expected<void> Session::set_culler(engine::CullerChoice choice) {
  return image.configure([this, choice](engine::EngineConfig& config) {
    config.culling.culler = choice;
    double& budget_ms = config.losses.budget_ms;
    if (may_use_gpu(choice) && budget_ms == default_budget_ms_) budget_ms = 0.0;
  });
}

core::Expected<void> colour_by(Session& session, const std::string& key) {
  if (session.changes()) return core::fail("end the comparison first: it has colours of its own");
  core::Expected<query::Colouring> made;
  if (!key.empty()) made = query::colour_by(session.scene(), key);
  if (!made) return tl::unexpected(made.error());
  BaseStyles styles;
  for (const query::ColourGroup& group : made->groups) styles.all.push_back({{.colour = group.colour}, true});
  for (const std::uint8_t group : made->of_item)
    styles.which.push_back(std::uint8_t(group < made->groups.size() ? group + 1 : 0));
  if (auto done = session.document.set_base_styles(std::move(styles)); !done) return done;
  session.colouring = std::move(*made);
  return {};
}

core::Expected<void> go_to_change(Session& session, std::size_t row) {
  ChangeList& changes = *session.changes();
  changes.set_current(row);
  const std::vector<core::ItemId> items = changes.items(session.scene(), row);
  if (auto done = session.document.select(items); !done) return done;
  session.tree.reveal(changes.node(session.scene(), row));
  core::AabbD bounds = session.document.bounds(items);
  if (bounds.empty()) return {};
  const core::dvec3 around(glm::length(bounds.size()));  // what it lies in is seen, too
  bounds.min -= around;
  bounds.max += around;
  session.camera.remember();
  session.camera.fit(bounds, session.image.aspect());
  return {};
}

}  // namespace sightline::apps
