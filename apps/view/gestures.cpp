#include "sightline/apps/view/gestures.h"

#include <algorithm>
#include <cmath>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>

#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/commands.h"
#include "sightline/apps/view/widgets.h"
#include "sightline/apps/view/workspace.h"

namespace sightline::apps {
namespace {

using Type = Event::Type;

constexpr double kRadiansPerHeight = 3.14159265358979;  // dragging from the bottom of the image to its top
constexpr double kClickPixels = 4.0;                    // a drag that moves no farther is a click
constexpr double kReach = 10.0;                         // pixels within which marks snap
constexpr double kDoubleClick = 0.35;                   // seconds
constexpr double kFaster = 8.0;                         // flying with Shift
constexpr double kFasterOnFoot = 3.0;                   // walking with Shift
constexpr double kSliderReach = 6.0;                    // pixels beside its line
constexpr double kTriadMargin = 6.0;                    // pixels beside the axes
constexpr double kTriadShare = 0.2;                     // of the image that they may reach over

/// Brings the tab that tells of it to the front, and its row of the tree into sight.
void select(Workspace& work, const std::optional<Taken>& taken, SelectMode mode) {
  Session& session = *work.session;
  work.messages.tell_outcome(session.document.select(taken ? taken->items : std::vector<core::ItemId>(), mode));
  if (!taken) return;
  work.shown.tab = "Item";
  session.tree.reveal(taken->node.valid() ? taken->node : session.scene().node_of(taken->item));
}

/// Puts the eye over the nearest floor, looking ahead. False where there is none.
bool stand_on_floor(Workspace& work, const Walker& walker) {
  Session& session = *work.session;
  core::Pose pose = session.camera.pose();
  const auto there = walker.nearest_floor(pose.eye, session.bounds().bounds);
  if (!there) return false;
  session.camera.remember();
  if (const double aside = glm::length(core::dvec2(*there - pose.eye)); aside > 0.0)
    work.messages.tell("no floor below: the nearest one is " + work.lengths().text(aside) + " aside");
  core::dvec3 sight = pose.target - pose.eye;
  const double length = glm::length(sight);
  if (sight.x == 0.0 && sight.y == 0.0) sight = pose.up;
  sight.z = 0.0;
  pose.eye = *there;
  pose.target = pose.eye + sight * (length / std::max(glm::length(sight), 1e-300));
  pose.up = {0.0, 0.0, 1.0};
  session.camera.set_pose(pose);
  return true;
}

void tell_section(Workspace& work, std::size_t index) {
  const auto& all = work.session->sections.all();
  if (index < all.size())
    work.messages.tell("kept: " + section_words(all[index], work.session->offset(), work.lengths()));
}

}  // namespace

std::optional<AxisTriad> Gestures::triad() const {
  const double scale = work_.gui.scale(), reach = AxisTriad::reach(scale),
               room = kTriadShare * std::min(work_.image.part().width, work_.image.part().height);
  if (!work_.session || !work_.shown.triad || !work_.shown.panels || reach > room) return std::nullopt;
  const double margin = reach + kTriadMargin * scale;
  return AxisTriad(work_.session->camera.pose(),
                   {work_.image.part().x + margin, work_.window.size()[1] - work_.image.part().y - margin}, scale);
}

std::optional<AxisTriad::End> Gestures::triad_end() const {
  const auto shows = drag_ || ImGui::GetIO().WantCaptureMouse ? std::nullopt : triad();
  return shows ? shows->end_at(cursor_) : std::nullopt;
}

std::optional<SectionHandles::Target> Gestures::section_target() const {
  if (section_handles_.dragging()) return section_handles_.dragged();
  if (drag_ || !shows_section_handles() || !work_.image.contains(cursor_) || ImGui::GetIO().WantCaptureMouse)
    return std::nullopt;
  return SectionHandles::at(*work_.session, work_.image.in_image(cursor_), work_.gui.scale());
}

bool Gestures::over_slider() const {
  if (drag_) return drag_->slides;
  if (!work_.session || !work_.session->slider.at() || !work_.image.contains(cursor_) ||
      ImGui::GetIO().WantCaptureMouse)
    return false;
  return std::abs(work_.image.in_image(cursor_).x - *work_.session->slider.at() * work_.image.part().width) <=
         kSliderReach * work_.gui.scale();
}

void Gestures::handle(const Event& event) {
  switch (event.type) {
    case Type::kKey:
      event.down ? press_key(event) : void(held_.erase(event.key));
      break;
    case Type::kButton:
      event.down ? press_button(event) : release_button(event);
      break;
    case Type::kCursor:
      move_cursor(event.at);
      break;
    case Type::kWheel:
      if (!work_.session || !work_.image.contains(event.at) || section_handles_.dragging()) break;
      work_.session->camera.remember();
      work_.session->camera.zoom(event.wheel, work_.session->point_at(work_.image.in_image(event.at)));
      break;
    case Type::kDrop:
      drop(event.files);
      break;
    case Type::kText:
    case Type::kExpose:
      break;
  }
}

/// A view file, or models.
void Gestures::drop(const std::vector<std::string>& files) {
  const bool view = files.size() == 1 && (files[0].ends_with(".json") || is_bcf(files[0]));
  if (!view) return work_.open(files);
  if (const char* why = missing(needs::kModel, work_)) return work_.messages.tell(why, true);
  work_.messages.tell_outcome(load_view(files[0], *work_.session, work_.views, work_.shown, work_.messages));
}

void Gestures::press_key(const Event& event) {
  const bool modifier = event.key >= GLFW_KEY_LEFT_SHIFT && event.key <= GLFW_KEY_RIGHT_SUPER;
  if (modifier || !(event.mods & GLFW_MOD_CONTROL)) held_.insert(event.key);  // Ctrl+S flies nowhere
  last_click_ = -1.0;
  const Command* command = find_command(event.key, event.mods);
  if (command && (!command->needs_model() || work_.session)) run(work_, *command);
}

void Gestures::escape() {
  if (section_handles_.dragging()) {
    drag_.reset();
    return section_handles_.cancel(*work_.session);
  }
  if (work_.gui.close_popup()) return;
  if (work_.shown.dialog != Dialog::kNone) return void(work_.shown.dialog = Dialog::kNone);
  if (work_.player.playing()) return work_.player.stop();
  if (work_.shown.tool == Tool::kMeasure && work_.session) work_.session->measuring.drop_mark();
  if (drag_ && draws_markup(work_, *drag_)) return drag_.reset();
  if (work_.shown.tool != Tool::kSelect) return void(work_.shown.tool = Tool::kSelect);
  if (walking()) return set_walking(false);
  if (work_.session && work_.session->slider.at()) return work_.messages.tell_outcome(set_slider(work_, "off"));
  if (work_.session) work_.messages.tell_outcome(work_.session->document.select({}));
}

void Gestures::press_button(const Event& event) {
  if (!work_.session || drag_ || !work_.image.contains(event.at)) return;
  cursor_ = event.at;
  if (const auto end = triad_end(); end && event.key == GLFW_MOUSE_BUTTON_LEFT)
    return run(work_, AxisTriad::view_from(*end));
  if (event.key == GLFW_MOUSE_BUTTON_LEFT && shows_section_handles() &&
      section_handles_.press(*work_.session, work_.image.in_image(event.at), work_.gui.scale())) {
    drag_ = {event.key, event.mods, event.at, event.at};
    return;
  }
  if (event.key == GLFW_MOUSE_BUTTON_LEFT && over_slider()) {
    drag_ = {event.key, event.mods, event.at, event.at};
    drag_->slides = true;
    return;
  }
  drag_ = {event.key, event.mods, event.at, event.at, work_.session->point_at(work_.image.in_image(event.at))};
  work_.session->camera.remember();
}

void Gestures::release_button(const Event& event) {
  if (!work_.session || !drag_ || drag_->button != event.key) return;
  move_cursor(event.at);
  const Drag drag = *std::exchange(drag_, std::nullopt);
  if (drag.slides) return;
  if (section_handles_.dragging()) {
    const auto target = section_handles_.dragged();
    section_handles_.release(*work_.session, !drag.moves);
    return target ? tell_section(work_, target->section) : void();
  }
  if (!drag.moves && drag.button == GLFW_MOUSE_BUTTON_LEFT)
    work_.session->engine.preparing_picks() ? void(click_ = drag) : click(drag);
  else if (!drag.moves && drag.button == GLFW_MOUSE_BUTTON_RIGHT)
    open_context_menu(drag.from);
  else if (draws_markup(work_, drag))
    mark_dragged(work_, drag);
  else if (drag.button == GLFW_MOUSE_BUTTON_LEFT && (drag.mods & GLFW_MOD_CONTROL) != 0)
    select_rectangle(drag);
}

void Gestures::move_cursor(const core::dvec2& to) {
  cursor_moved_ |= to != cursor_;
  cursor_ = to;
  if (!drag_ || !work_.session) return;
  const core::dvec2 by = (to - drag_->last) / double(std::max(1, work_.image.part().height));
  drag_->last = to;
  drag_->moves |= glm::length(to - drag_->from) > kClickPixels * work_.gui.scale();
  if (!drag_->moves) return;
  if (drag_->slides)
    return work_.messages.tell_outcome(
        work_.session->set_slider(work_.image.in_image(to).x / std::max(1, work_.image.part().width)));
  if (section_handles_.dragging()) {
    const auto holds = [&](int mod, int left, int right) {
      return (drag_->mods & mod) != 0 || held_.contains(left) || held_.contains(right);
    };
    return section_handles_.drag(*work_.session, work_.image.in_image(to),
                                 {.round = holds(GLFW_MOD_CONTROL, GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL),
                                  .model = holds(GLFW_MOD_SHIFT, GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT)});
  }
  Camera& camera = work_.session->camera;
  const core::dvec2 turn = kRadiansPerHeight * core::dvec2(by.x, -by.y);
  const bool left = drag_->button == GLFW_MOUSE_BUTTON_LEFT;
  if (left && (drag_->mods & GLFW_MOD_CONTROL) != 0) return;  // a rectangle
  if (draws_markup(work_, *drag_)) return;
  if (drag_->button == GLFW_MOUSE_BUTTON_MIDDLE || (left && (drag_->mods & GLFW_MOD_SHIFT) != 0))
    camera.pan({by.x, -by.y}, drag_->point);
  else if (left)
    camera.orbit(turn, drag_->point);
  else
    camera.look(turn);
}

void Gestures::set_mark(const core::dvec2& at) {
  const auto aimed = work_.session->aim(work_.image.in_image(at), kReach * work_.gui.scale());
  if (!aimed) return work_.messages.tell(aimed.error().message, true);
  if (!*aimed) return work_.messages.tell("there is nothing to measure", true);
  work_.session->measuring.add((*aimed)->item, (*aimed)->snap);
  work_.messages.tell((*aimed)->snap.words);
}

void Gestures::click(const Drag& drag) {
  if (work_.shown.tool == Tool::kMeasure) return set_mark(drag.from);
  if (work_.shown.tool == Tool::kMark) return mark_clicked(work_, drag.from);
  if (work_.shown.tool == Tool::kSection) {
    const auto done = cut_at(under(drag.from), *work_.session, work_.shown);
    if (!done) return work_.messages.tell_outcome(done);
    work_.shown.tool = Tool::kSelect;
    return tell_section(work_, work_.session->sections.all().size() - 1);
  }
  const auto hit = work_.session->pick(work_.image.in_image(drag.from));
  if (!hit) return work_.messages.tell(hit.error().message, true);
  const SelectMode mode = (drag.mods & GLFW_MOD_CONTROL) != 0 ? SelectMode::kToggle
                          : (drag.mods & GLFW_MOD_SHIFT) != 0 ? SelectMode::kAdd
                                                              : SelectMode::kReplace;
  const core::Scene& scene = work_.session->scene();
  const std::optional<Taken> taken =
      *hit ? std::optional(taken_at(scene, (*hit)->item, work_.shown.level)) : std::nullopt;
  const double now = drag.mods == 0 ? glfwGetTime() : -1.0;
  const bool again = drag.mods == 0 && now - last_click_ < kDoubleClick &&
                     glm::length(drag.from - last_click_at_) <= kClickPixels * work_.gui.scale();
  last_click_at_ = drag.from;
  last_click_ = now;
  if (again && taken) {
    work_.session->camera.fit(work_.session->document.bounds(taken->items), work_.session->image.aspect());
    return work_.messages.tell_outcome({});
  }
  select(work_, taken, mode);
}

/// Opens the menu of what the cursor is over, which is selected unless it is part of the selection.
void Gestures::open_context_menu(const core::dvec2& at) {
  context_face_.reset();
  work_.shown.context = true;
  if (work_.session->engine.preparing_picks()) return;
  const auto hit = under(at);
  if (!hit) return work_.messages.tell(hit.error().message, true);
  context_face_ = *hit;
  Document& document = work_.session->document;
  if (!*hit || document.is((*hit)->item, Document::kSelected)) return;
  select(work_, taken_at(work_.session->scene(), (*hit)->item, work_.shown.level), SelectMode::kReplace);
}

void Gestures::select_rectangle(const Drag& drag) {
  const core::dvec2 a = work_.image.in_image(drag.from), b = work_.image.in_image(drag.last);
  const engine::PixelRectangle rectangle{std::min(a.x, b.x), std::min(a.y, b.y), std::max(a.x, b.x),
                                         std::max(a.y, b.y)};
  const auto rule = b.x < a.x ? culling::RegionRule::kCrossing : culling::RegionRule::kWholly;
  const auto found = work_.session->items_in(rectangle, rule);
  if (!found) return work_.messages.tell(found.error().message, true);
  const Document& document = work_.session->document;
  std::vector<core::ItemId> items;
  for (const auto& taken :
       taken_by(work_.session->scene(), *found, work_.shown.level, rule == culling::RegionRule::kWholly,
                [&](core::ItemId item) { return document.shown(item); }))
    items.insert(items.end(), taken.begin(), taken.end());
  const auto mode = (drag.mods & GLFW_MOD_SHIFT) != 0 ? SelectMode::kAdd : SelectMode::kReplace;
  work_.messages.tell_outcome(work_.session->document.select(items, mode));
}

void Gestures::let_go() {
  held_.clear();
  drag_.reset();
  section_handles_.forget();
}

void Gestures::forget_model() {
  set_walking(false);
  section_handles_.forget();
}

bool Gestures::moves() const {
  return (walker_ && walker_->falling()) || std::any_of(held_.begin(), held_.end(), [](int key) {
           return key == GLFW_KEY_W || key == GLFW_KEY_A || key == GLFW_KEY_S || key == GLFW_KEY_D ||
                  key == GLFW_KEY_Q || key == GLFW_KEY_E;
         });
}

bool Gestures::waits_for_picks() const {
  return work_.session && (cursor_moved_ || click_) && !drag_ && work_.session->engine.preparing_picks();
}

bool Gestures::shows_section_handles() const {
  return work_.session && work_.shown.section_handles && work_.shown.panels;
}

core::Expected<std::optional<engine::Pick>> Gestures::under(const core::dvec2& at) {
  if (!work_.image.contains(at)) return std::optional<engine::Pick>();
  return work_.session->pick(work_.image.in_image(at));
}

void Gestures::fly(double seconds) {
  if (!work_.session || work_.exports.image() || work_.gui.has_text_cursor()) return;
  const auto key = [&](int name) { return held_.contains(name) ? 1.0 : 0.0; };
  if (key(GLFW_KEY_LEFT_CONTROL) + key(GLFW_KEY_RIGHT_CONTROL) + key(GLFW_KEY_LEFT_ALT) > 0.0) return;
  const core::dvec3 move(key(GLFW_KEY_D) - key(GLFW_KEY_A), key(GLFW_KEY_W) - key(GLFW_KEY_S),
                         key(GLFW_KEY_E) - key(GLFW_KEY_Q));
  const bool falls = walker_ && walker_->falling() && !drag_;
  if (move == core::dvec3(0.0) && !falls) return;
  const bool fast = held_.contains(GLFW_KEY_LEFT_SHIFT) || held_.contains(GLFW_KEY_RIGHT_SHIFT);
  if (walker_) return walk((fast ? kFasterOnFoot : 1.0) * move, seconds);
  work_.session->camera.fly(move, seconds * (fast ? kFaster : 1.0));
}

void Gestures::set_walking(bool walking) {
  walker_.reset();
  if (!walking) return;
  work_.session->camera.set_orthographic(false);
  walker_.emplace([this](const core::dvec3& origin, const core::dvec3& direction, double reach) {
    const auto view = work_.session->image.view();
    std::optional<double> distance;
    if (!view) return distance;
    const core::Ray ray{origin, direction, 0.0, reach};
    if (const auto hit = work_.session->engine.pick(ray, raytrace::filter_of(*view)); hit && *hit) distance = (*hit)->t;
    return distance;
  });
  if (stand_on_floor(work_, *walker_)) return;
  walker_.reset();
  work_.messages.tell("there is no floor to walk on, below or beside", true);
}

/// By what is held: to the right and ahead, over the ground.
void Gestures::walk(const core::dvec3& held, double seconds) {
  core::Pose pose = work_.session->camera.pose();
  const core::dvec3 sight = pose.target - pose.eye;
  core::dvec2 ahead(sight.x, sight.y);
  if (glm::length(ahead) == 0.0) ahead = core::dvec2(pose.up.x, pose.up.y);  // straight up or down
  ahead /= std::max(glm::length(ahead), 1e-300);
  const core::dvec2 velocity = Walker::kSpeed * (held.y * ahead + held.x * core::dvec2(ahead.y, -ahead.x));
  pose.eye = walker_->move(pose.eye, velocity, seconds);
  pose.target = pose.eye + sight;
  work_.session->camera.set_pose(pose);
}

void Gestures::hover() {
  if (!work_.session || drag_ || work_.exports.image() || work_.session->engine.preparing_picks()) return;
  if (click_) click(*std::exchange(click_, std::nullopt));
  // What was there may be hidden now, or elsewhere in the image.
  const std::uint64_t version = work_.session->document.version();
  bool changed = std::exchange(hovered_version_, version) != version;
  if (const auto view = work_.session->image.view();
      view && !(hovered_view_ && core::same_image(*view, *hovered_view_))) {
    hovered_view_ = *view;
    changed = true;
  }
  if (!std::exchange(cursor_moved_, false) && !changed) return;
  std::optional<Taken> taken;
  const bool over_image = work_.image.contains(cursor_) && !ImGui::GetIO().WantCaptureMouse && !triad_end() &&
                          !section_target() && !over_slider();
  aimed_.reset();
  cursor_point_.reset();
  if (over_image && work_.shown.tool == Tool::kMeasure) {
    if (const auto aimed = work_.session->aim(work_.image.in_image(cursor_), kReach * work_.gui.scale());
        aimed && *aimed) {
      aimed_ = (*aimed)->snap;
      cursor_point_ = aimed_->point;
    }
  } else if (over_image) {
    if (const auto hit = work_.session->pick(work_.image.in_image(cursor_)); hit && *hit) {
      std::optional<Taken>& before = work_.session->document.hovered;
      const core::NodeId node = node_at(work_.session->scene(), (*hit)->item, work_.shown.level);
      if (before && node.valid() && before->node == node)  // files have very many items
        taken = std::move(before), taken->item = (*hit)->item;
      else
        taken = taken_at(work_.session->scene(), (*hit)->item, work_.shown.level);
      cursor_point_ = (*hit)->point;
    }
  }
  work_.session->document.hovered = std::move(taken);
}

}  // namespace sightline::apps
