#include "sightline/apps/view/session.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "sightline/apps/view/portion.h"
#include "sightline/core/image_rays.h"
#include "sightline/core/internal/sort_unique.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::apps {
namespace {

constexpr std::size_t kMostPlaces = 200;

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

Session::Session(Model model, engine::Engine engine, const engine::EngineConfig& config)
    : model_(std::move(model)),
      engine_(std::move(engine)),
      document_(*model_.scene, engine_),
      tree_(*model_.scene),
      bounds_(engine_.snapshot().bounds().fitted_bounds()),
      size_{config.width, config.height},
      motion_error_(config.losses.lod_error),
      camera_(bounds_.bounds, kFovy, aspect()) {}

void Session::show_all(const std::optional<core::dvec3>& direction) {
  const core::ItemBounds& items = engine_.snapshot().bounds();
  const std::vector<core::Plane> sections = sections_.planes();
  if (direction)
    camera_.show_all(items, *direction, aspect(), sections);
  else
    camera_.show_all(items, aspect(), sections);
}

core::Expected<bool> Session::begin(gl::Context& context, const std::array<int, 2>& size) {
  if (!budget_ms_) {
    engine::EngineConfig config = engine_.config();
    budget_ms_ = config.losses.budget_ms;
    config.losses.budget_ms = 1e3 * kPortion;
    (void)engine_.configure(config);  // it cannot while the GPU must cull: then the first image is drawn at once
  }
  if (auto done = resize(size); !done) return tl::unexpected(done.error());
  uploaded_ = engine_.drawing();
  if (!uploaded_)
    return engine_.use_context(context, kPortion).map([this](bool done) {
      uploaded_ = done;
      return false;
    });
  if (fitted_aspect_ != aspect()) {  // not in each portion: it takes a tenth of a second for a million items
    fitted_aspect_ = aspect();
    camera_ = Camera(bounds_.bounds, kFovy, fitted_aspect_);
    show_all(core::kOverviewDirection);
  }
  if (const auto drawn = draw(); !drawn) return engine_.drawing() ? drawn : core::Expected<bool>(false);
  if (report_.pending > 0) return false;
  engine::EngineConfig config = engine_.config();
  config.losses.budget_ms = budget_in_use(*std::exchange(budget_ms_, std::nullopt));
  config.losses.lod_error = has_levels() ? motion_error_ : 0.0;  // so that levels are built from now on
  if (auto done = engine_.configure(config); !done) return tl::unexpected(done.error());
  return true;
}

double Session::budget_in_use(double asked_for) const {
  return asked_for > 0.0 || may_use_gpu(engine_.config().culling.culler) ? asked_for : default_budget_ms_;
}

core::Expected<void> Session::use_context(gl::Context& context) {
  changed();
  if (frozen_) frozen_->forget();
  return engine_.use_context(context);
}

core::Expected<void> Session::resize(const std::array<int, 2>& size) {
  return size == size_ ? core::Expected<void>() : resize(size, coarse_);
}

core::Expected<void> Session::set_coarse(bool coarse) {
  return coarse == coarse_ ? core::Expected<void>() : resize(size_, coarse);
}

core::Expected<void> Session::resize(const std::array<int, 2>& size, bool coarse) {
  if (frozen_ && size != size_) frozen_->forget();
  const auto former = std::pair(size_, coarse_);
  std::tie(size_, coarse_) = std::tie(size, coarse);
  const std::array<int, 2> drawn = drawn_size();
  auto done = engine_.resize(drawn[0], drawn[1]);
  if (!done) std::tie(size_, coarse_) = former;
  changed();
  return done;
}

std::array<int, 2> Session::drawn_size() const {
  return coarse_ ? std::array{(size_[0] + 1) / 2, (size_[1] + 1) / 2} : size_;
}

/// Not where they would need another culler: that would cost more than they save.
bool Session::has_levels() const {
  const core::Snapshot& snapshot = engine_.snapshot();
  const bool meshes = !snapshot.of_kind(core::Kind::kMesh).members.empty() ||
                      !snapshot.of_kind(core::Kind::kFacetGroup).members.empty();
  return meshes && !engine_.plan().gpu_culls();
}

core::Expected<void> Session::set_motion_error(double pixels) {
  motion_error_ = pixels;
  return set_moving(true);
}

core::Expected<void> Session::set_moving(bool moving) {
  engine::EngineConfig config = engine_.config();
  const double error = moving && has_levels() ? motion_error_ : 0.0;
  if (config.losses.lod_error == error) return {};
  const auto lost = loss();
  if (!lost || lost->lod_error > error) changed();
  config.losses.lod_error = error;
  return engine_.configure(config);
}

core::Expected<core::View> Session::view(const core::dvec2& shift) const {
  return view_of(camera_, aspect(), shift);
}

core::Expected<core::View> Session::view_of(const Camera& camera, double aspect, const core::dvec2& shift) const {
  auto view = camera.view(aspect, shift);
  if (view) view->sections = sections_.planes();
  return view;
}

bool Session::stale() const {
  const auto seen = view();
  return !drawn_ || report_.pending > 0 || drawn_version_ != document_.version() ||
         (seen && !core::same_image(*seen, *drawn_));
}

core::Expected<bool> Session::draw() {
  if (!stale()) return false;
  const auto seen = view();
  if (!seen) return tl::unexpected(seen.error());
  if (frozen_)
    if (auto done = frozen_->follow(engine_, seen->sections, document_.solid_version()); !done)
      return tl::unexpected(done.error());
  const auto report = frame(*seen);
  if (!report) return tl::unexpected(report.error());
  if (!report->drawn) return core::fail("the GL context was lost");
  drawn_ = *seen;
  drawn_version_ = document_.version();
  resting_.clear();
  loss_.reset();
  report_ = *report;
  if (report->visible >= 0) visible_ = report->visible;
  while (const auto late = engine_.take_late_report()) visible_ = late->visible;
  return true;
}

core::Expected<void> Session::refine() {
  if (!refining()) return {};
  const core::dvec2 shift = resting_.shift() / core::dvec2(size_[0], size_[1]);
  const auto view = this->view(shift);
  if (!view) return tl::unexpected(view.error());
  const auto report = frame(*view);
  if (!report) return tl::unexpected(report.error());
  if (report->pending > 0) return {};
  const auto image = read_image();
  if (!image) return tl::unexpected(image.error());
  resting_.add(*image);
  if (resting_.complete()) mean_ = resting_.mean();
  return {};
}

core::Expected<image::Image> Session::image(bool smooth) {
  if (auto done = set_coarse(false); !done) return tl::unexpected(done.error());
  if (auto done = set_moving(false); !done) return tl::unexpected(done.error());
  if (const auto drawn = draw(); !drawn) return tl::unexpected(drawn.error());
  if (const image::Image* mean = smooth ? this->smooth() : nullptr) return *mean;
  return read_image();
}

core::Expected<void> Session::outline_hovered(const gl::ExternalTarget& target) {
  const auto item = document_.hovered();
  if (!item || !drawn_ || coarse_ || document_.is(*item, Document::kSelected)) return {};
  if (auto done = turn_to(*item); !done) return done;
  return engine_.draw_outline(*drawn_, std::span(&*item, 1), target);
}

core::Expected<std::optional<engine::Pick>> Session::pick(const core::dvec2& at) {
  const auto seen = view();
  const auto ray = seen ? core::image_ray(*seen, size_[0], size_[1], at.x, at.y) : tl::unexpected(seen.error());
  if (!ray) return tl::unexpected(ray.error());
  if (auto done = turn_to_column(at.x); !done) return tl::unexpected(done.error());
  return engine_.pick(*ray, raytrace::filter_of(*seen));
}

core::Expected<std::vector<core::ItemId>> Session::items_in(const engine::PixelRectangle& rectangle,
                                                            culling::RegionRule rule) {
  const auto seen = view();
  if (!seen) return tl::unexpected(seen.error());
  const std::array<int, 2> drawn = drawn_size();
  const double x = double(drawn[0]) / size_[0], y = double(drawn[1]) / size_[1];
  std::vector<core::ItemId> items;
  for (const ImagePart& part : parts()) {
    engine::PixelRectangle own{x * rectangle.x0, y * rectangle.y0, x * rectangle.x1, y * rectangle.y1};
    if (part.begin > 0) own.x0 = std::max(own.x0, double(part.begin));
    if (part.end < drawn[0]) own.x1 = std::min(own.x1, double(part.end));
    if (slider_ && own.x0 >= own.x1) continue;
    if (auto done = slider_ ? turn_to(part.revision) : core::Expected<void>(); !done)
      return tl::unexpected(done.error());
    const auto found = engine_.items_in(*seen, own, rule);
    if (!found) return found;
    items.insert(items.end(), found->begin(), found->end());
  }
  core::sort_unique(items);
  return items;
}

core::Expected<std::optional<Session::Aimed>> Session::aim(const core::dvec2& at, double reach) {
  const auto seen = view();
  if (!seen) return tl::unexpected(seen.error());
  const auto hit = pick(at);
  if (!hit) return tl::unexpected(hit.error());
  const auto ray = core::image_ray(*seen, size_[0], size_[1], at.x, at.y);
  if (!*hit || !ray) return std::nullopt;
  const auto item = measured_item(scene(), (*hit)->item);
  if (!item) return tl::unexpected(item.error());
  const double per_pixel = 2.0 * std::tan(0.5 * camera_.fovy()) / size_[1];  // at the distance of one metre
  measure::Aim aim{(*hit)->point, 0.0, measure::AimRay{ray->origin, ray->direction, 0.0}};
  if (camera_.orthographic())
    aim.radius = reach * per_pixel * glm::length(camera_.pose().target - camera_.pose().eye);
  else
    aim.ray->slope = reach * per_pixel;
  const auto snap = measure::snap(*item, aim, seen->sections, seen->section_mode);
  if (!snap) return std::nullopt;
  return Aimed{(*hit)->item, *snap};
}

core::dvec3 Session::point_at(const core::dvec2& at) {
  const core::Pose& pose = camera_.pose();
  const auto seen = view();
  if (!seen) return pose.target;
  if (!engine_.preparing_picks())
    if (const auto hit = pick(at); hit && *hit) return (*hit)->point;
  const core::dvec3 ahead = glm::normalize(pose.target - pose.eye);
  const auto ray = core::image_ray(*seen, size_[0], size_[1], at.x, at.y);
  const double along = ray ? glm::dot(ray->direction, ahead) : 0.0;
  if (!(along > 0.0)) return pose.target;
  return ray->origin + ray->direction * (glm::dot(pose.target - ray->origin, ahead) / along);
}

const ItemNames& Session::names() const {
  if (!names_) names_.emplace(scene());
  return *names_;
}

const TreeStates& Session::tree_states() {
  tree_states_.follow(tree_.rows(), scene(), document_);
  return tree_states_;
}

const std::vector<Finding>& Session::findings() {
  if (!findings_) findings_ = sightline::apps::findings(scene(), bounds_);
  return *findings_;
}

Viewpoint Session::viewpoint() const {
  Viewpoint seen;
  seen.pose = camera_.pose();
  seen.fovy = camera_.fovy();
  seen.orthographic = camera_.orthographic();
  seen.near = camera_.near();
  seen.sections = sections_.planes();
  seen.measurements = measuring_.list();
  seen.shown.emplace();
  if (document_.hidden() > 0) seen.shown->hidden = names().name(document_.items_with(Document::kHidden), true);
  if (document_.ghosts() > 0) seen.shown->ghosts = names().name(document_.items_with(Document::kGhost), false);
  if (!document_.selection().empty()) seen.shown->selection = names().name(document_.selection(), false);
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
  remember();
  camera_.set_pose(there.pose);
  camera_.set_fovy(there.fovy);
  camera_.set_orthographic(there.orthographic);
  if (!there.orthographic && there.near > 0.0) camera_.set_planes(there.near, core::kInfiniteFar);
  sections_.set(there.sections, bounds_.bounds);
  measuring_.merge(there.measurements);
  if (!there.shown) return 0;
  const Viewpoint::Shown& shown = *there.shown;
  const auto hidden = names().find(shown.hidden), ghosts = names().find(shown.ghosts),
             selected = names().find(shown.selection);
  if (auto done = document_.set(hidden.items, ghosts.items, selected.items); !done) return tl::unexpected(done.error());
  return hidden.missing + ghosts.missing + selected.missing;
}

/// All that depends on the scene follows, whether the edit fails or not.
core::Expected<void> Session::edit_scene(const std::function<core::Expected<void>(core::Scene&)>& edit) {
  tree_.release_scene();
  auto done = edit(*model_.scene);
  const auto committed = engine_.commit();
  document_.follow_scene();
  tree_.follow_scene();
  names_.reset();
  findings_.reset();
  bounds_ = engine_.snapshot().bounds().fitted_bounds();
  changed();
  return done ? committed : done;
}

core::Expected<void> Session::begin_comparison(std::unique_ptr<ChangeList> changes) {
  if (auto ended = end_comparison(); !ended) return ended;
  changes_ = std::move(changes);
  auto done = edit_scene([&](core::Scene& scene) { return changes_->add_removed(scene); });
  if (done) done = document_.set_base_styles(changes_->base_styles());
  if (done) return done;
  if (const auto ended = end_comparison(); !ended) return ended;
  return done;
}

core::Expected<void> Session::end_comparison() {
  if (!changes_) return {};
  if (auto done = set_slider({}); !done) return done;
  auto done = document_.set_base_styles({});
  const auto edited = edit_scene([&](core::Scene& scene) -> core::Expected<void> {
    changes_->take_removed(scene);
    return {};
  });
  changes_.reset();
  return done ? edited : done;
}

core::Expected<void> Session::show_changes(compare::State state, bool shown) {
  changes_->set_shown(state, shown);
  if (auto done = document_.set_base_styles(changes_->base_styles()); !done) return done;
  const std::vector<core::ItemId> selection(document_.selection().begin(), document_.selection().end());
  return document_.select(selection);  // but for those that are no longer seen
}

core::Expected<void> Session::go_to_change(std::size_t row) {
  changes_->set_current(row);
  const std::vector<core::ItemId> items = changes_->items(scene(), row);
  if (auto done = document_.select(items); !done) return done;
  tree_.reveal(changes_->node(scene(), row));
  core::AabbD bounds = document_.bounds(items);
  if (bounds.empty()) return {};
  const core::dvec3 around(glm::length(bounds.size()));  // what it lies in is seen, too
  bounds.min -= around;
  bounds.max += around;
  remember();
  camera_.fit(bounds, aspect());
  return {};
}

void Session::remember() {
  const core::Pose& pose = camera_.pose();
  if (!places_.empty() && places_.back().first.eye == pose.eye && places_.back().first.target == pose.target) return;
  places_.emplace_back(pose, camera_.orthographic());
  if (places_.size() > kMostPlaces) places_.erase(places_.begin());
}

void Session::camera_back() {
  const core::dvec3 eye = camera_.pose().eye;
  while (!places_.empty() && places_.back().first.eye == eye && places_.size() > 1) places_.pop_back();
  if (places_.empty()) return;
  camera_.set_pose(places_.back().first);
  camera_.set_orthographic(places_.back().second);
  places_.pop_back();
}

void Session::set_frozen(bool frozen) {
  frozen_.reset();
  if (frozen && drawn_) frozen_.emplace(*drawn_);
  changed();
}

std::optional<engine::LossReport> Session::loss() {
  if (stale() || frozen_) return std::nullopt;
  if (!loss_)
    if (const auto loss = engine_.loss(*drawn_)) loss_ = *loss;
  return loss_;
}

core::Expected<void> Session::set_culler(engine::CullerChoice choice) {
  return configure([this, choice](engine::EngineConfig& config) {
    config.culling.culler = choice;
    double& budget_ms = config.losses.budget_ms;
    if (may_use_gpu(choice) && budget_ms == default_budget_ms_) budget_ms = 0.0;
  });
}

core::Expected<void> Session::configure(const std::function<void(engine::EngineConfig&)>& change) {
  engine::EngineConfig config = engine_.config();
  change(config);
  auto done = engine_.configure(config);
  changed();
  if (frozen_) frozen_->forget();
  return done;
}

}  // namespace sightline::apps
