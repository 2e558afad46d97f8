// What mouse and keys do in the image.
#include <algorithm>
#include <cmath>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>

#include "sightline/apps/view/commands.h"
#include "sightline/apps/view/comparing.h"
#include "sightline/apps/view/section_commands.h"
#include "sightline/apps/view/viewer.h"
#include "sightline/apps/view/widgets.h"

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

}  // namespace

core::dvec2 Viewer::in_image(const core::dvec2& cursor) const {
  return {cursor.x - part_.x, cursor.y - (window_.size()[1] - part_.y - part_.height)};
}

bool Viewer::in_viewport(const core::dvec2& cursor) const {
  const core::dvec2 at = in_image(cursor);
  return at.x >= 0.0 && at.y >= 0.0 && at.x < part_.width && at.y < part_.height;
}

std::optional<AxisTriad> Viewer::triad() const {
  const double scale = gui_.scale(), reach = AxisTriad::reach(scale),
               room = kTriadShare * std::min(part_.width, part_.height);
  if (!session_ || !shown.triad || !shown.panels || reach > room) return std::nullopt;
  const double margin = reach + kTriadMargin * scale;
  return AxisTriad(session_->camera().pose(), {part_.x + margin, window_.size()[1] - part_.y - margin}, scale);
}

std::optional<AxisTriad::End> Viewer::triad_end() const {
  const auto shows = drag_ || ImGui::GetIO().WantCaptureMouse ? std::nullopt : triad();
  return shows ? shows->end_at(cursor_) : std::nullopt;
}

std::optional<SectionHandles::Target> Viewer::section_target() const {
  if (section_handles_.dragging()) return section_handles_.dragged();
  if (drag_ || !shows_section_handles() || !in_viewport(cursor_) || ImGui::GetIO().WantCaptureMouse)
    return std::nullopt;
  return SectionHandles::at(*session_, in_image(cursor_), gui_.scale());
}

bool Viewer::over_slider() const {
  if (drag_) return drag_->slides;
  if (!session_ || !session_->slider() || !in_viewport(cursor_) || ImGui::GetIO().WantCaptureMouse) return false;
  return std::abs(in_image(cursor_).x - *session_->slider() * part_.width) <= kSliderReach * gui_.scale();
}

void Viewer::handle(const Event& event) {
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
      if (!session_ || !in_viewport(event.at) || section_handles_.dragging()) break;
      session_->remember();
      session_->camera().zoom(event.wheel, session_->point_at(in_image(event.at)));
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
void Viewer::drop(const std::vector<std::string>& files) {
  const bool view = files.size() == 1 && (files[0].ends_with(".json") || is_bcf(files[0]));
  if (!view) return open(files);
  if (!session_) return tell("open a model first", true);
  tell_outcome(load_view(files[0]));
}

void Viewer::press_key(const Event& event) {
  const bool modifier = event.key >= GLFW_KEY_LEFT_SHIFT && event.key <= GLFW_KEY_RIGHT_SUPER;
  if (modifier || !(event.mods & GLFW_MOD_CONTROL)) held_.insert(event.key);  // Ctrl+S flies nowhere
  last_click_ = -1.0;
  const Command* command = find_command(event.key, event.mods);
  if (command && (!command->needs_model() || session_)) sightline::apps::run(*this, *command);
}

void Viewer::escape() {
  if (section_handles_.dragging()) {
    drag_.reset();
    return section_handles_.cancel(*session_);
  }
  if (gui_.close_popup()) return;
  if (shown.dialog != Dialog::kNone) return void(shown.dialog = Dialog::kNone);
  if (player_.playing()) return player_.stop();
  if (shown.tool == Tool::kMeasure && session_) session_->measuring().drop_mark();
  if (shown.tool != Tool::kSelect) return void(shown.tool = Tool::kSelect);
  if (walking()) return set_walking(false);
  if (session_ && session_->slider()) return tell_outcome(set_slider(*this, "off"));
  if (session_) tell_outcome(session_->document().select({}));
}

void Viewer::press_button(const Event& event) {
  if (!session_ || drag_ || !in_viewport(event.at)) return;
  cursor_ = event.at;
  if (const auto end = triad_end(); end && event.key == GLFW_MOUSE_BUTTON_LEFT)
    return sightline::apps::run(*this, *find_command(AxisTriad::view_from(*end)));
  if (event.key == GLFW_MOUSE_BUTTON_LEFT && shows_section_handles() &&
      section_handles_.press(*session_, in_image(event.at), gui_.scale())) {
    drag_ = {event.key, event.mods, event.at, event.at};
    return;
  }
  if (event.key == GLFW_MOUSE_BUTTON_LEFT && over_slider()) {
    drag_ = {event.key, event.mods, event.at, event.at};
    drag_->slides = true;
    return;
  }
  drag_ = {event.key, event.mods, event.at, event.at, session_->point_at(in_image(event.at))};
  session_->remember();
}

void Viewer::release_button(const Event& event) {
  if (!session_ || !drag_ || drag_->button != event.key) return;
  move_cursor(event.at);
  const Drag drag = *std::exchange(drag_, std::nullopt);
  if (drag.slides) return;
  if (section_handles_.dragging()) return section_handles_.release(*session_, !drag.moves);
  if (!drag.moves && drag.button == GLFW_MOUSE_BUTTON_LEFT)
    session_->engine().preparing_picks() ? void(click_ = drag) : click(drag);
  else if (!drag.moves && drag.button == GLFW_MOUSE_BUTTON_RIGHT)
    open_context_menu(drag.from);
  else if (drag.button == GLFW_MOUSE_BUTTON_LEFT && (drag.mods & GLFW_MOD_CONTROL) != 0)
    select_rectangle(drag);
}

void Viewer::move_cursor(const core::dvec2& to) {
  cursor_moved_ |= to != cursor_;
  cursor_ = to;
  if (!drag_ || !session_) return;
  const core::dvec2 by = (to - drag_->last) / double(std::max(1, part_.height));
  drag_->last = to;
  drag_->moves |= glm::length(to - drag_->from) > kClickPixels * gui_.scale();
  if (!drag_->moves) return;
  if (drag_->slides) return tell_outcome(session_->set_slider(in_image(to).x / std::max(1, part_.width)));
  if (section_handles_.dragging()) {
    const auto holds = [&](int mod, int left, int right) {
      return (drag_->mods & mod) != 0 || held_.contains(left) || held_.contains(right);
    };
    return section_handles_.drag(*session_, in_image(to),
                                 {.round = holds(GLFW_MOD_CONTROL, GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL),
                                  .model = holds(GLFW_MOD_SHIFT, GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT)});
  }
  Camera& camera = session_->camera();
  const core::dvec2 turn = kRadiansPerHeight * core::dvec2(by.x, -by.y);
  const bool left = drag_->button == GLFW_MOUSE_BUTTON_LEFT;
  if (left && (drag_->mods & GLFW_MOD_CONTROL) != 0) return;  // a rectangle
  if (drag_->button == GLFW_MOUSE_BUTTON_MIDDLE || (left && (drag_->mods & GLFW_MOD_SHIFT) != 0))
    camera.pan({by.x, -by.y}, drag_->point);
  else if (left)
    camera.orbit(turn, drag_->point);
  else
    camera.look(turn);
}

void Viewer::set_mark(const core::dvec2& at) {
  const auto aimed = session_->aim(in_image(at), kReach * gui_.scale());
  if (!aimed) return tell(aimed.error().message, true);
  if (!*aimed) return tell("there is nothing to measure", true);
  session_->measuring().add((*aimed)->item, (*aimed)->snap);
  tell((*aimed)->snap.words);
}

void Viewer::click(const Drag& drag) {
  if (shown.tool == Tool::kMeasure) return set_mark(drag.from);
  if (shown.tool == Tool::kSection) {
    const auto done = cut_at(*this, under(drag.from));
    if (!done) return tell_outcome(done);
    shown.tool = Tool::kSelect;
    return tell("kept: " + section_words(session_->sections().all().back(), session_->offset(), lengths()));
  }
  const auto hit = session_->pick(in_image(drag.from));
  if (!hit) return tell(hit.error().message, true);
  const SelectMode mode = (drag.mods & GLFW_MOD_CONTROL) != 0 ? SelectMode::kToggle
                          : (drag.mods & GLFW_MOD_SHIFT) != 0 ? SelectMode::kAdd
                                                              : SelectMode::kReplace;
  std::vector<core::ItemId> items;
  if (*hit) items.push_back((*hit)->item);
  const double now = drag.mods == 0 ? glfwGetTime() : -1.0;
  const bool again = drag.mods == 0 && now - last_click_ < kDoubleClick &&
                     glm::length(drag.from - last_click_at_) <= kClickPixels * gui_.scale();
  last_click_at_ = drag.from;
  last_click_ = now;
  if (again && !items.empty()) {
    session_->camera().fit(session_->document().bounds(items), session_->aspect());
    return tell_outcome({});
  }
  tell_outcome(session_->document().select(items, mode));
  if (!items.empty()) session_->tree().reveal(session_->scene().node_of(items[0]));
}

/// Opens the menu of what the cursor is over, which is selected unless it is part of the selection.
void Viewer::open_context_menu(const core::dvec2& at) {
  context_face_.reset();
  shown.context = true;
  if (session_->engine().preparing_picks()) return;
  const auto hit = under(at);
  if (!hit) return tell(hit.error().message, true);
  context_face_ = *hit;
  Document& document = session_->document();
  if (!*hit || document.is((*hit)->item, Document::kSelected)) return;
  tell_outcome(document.select(std::span(&(*hit)->item, 1)));
  session_->tree().reveal(session_->scene().node_of((*hit)->item));
}

void Viewer::select_rectangle(const Drag& drag) {
  const core::dvec2 a = in_image(drag.from), b = in_image(drag.last);
  const engine::PixelRectangle rectangle{std::min(a.x, b.x), std::min(a.y, b.y), std::max(a.x, b.x),
                                         std::max(a.y, b.y)};
  const auto rule = b.x < a.x ? culling::RegionRule::kCrossing : culling::RegionRule::kWholly;
  const auto items = session_->items_in(rectangle, rule);
  if (!items) return tell(items.error().message, true);
  const auto mode = (drag.mods & GLFW_MOD_SHIFT) != 0 ? SelectMode::kAdd : SelectMode::kReplace;
  tell_outcome(session_->document().select(*items, mode));
}

void Viewer::draw_rectangle() const {
  if (!drag_ || !drag_->moves || drag_->button != GLFW_MOUSE_BUTTON_LEFT || (drag_->mods & GLFW_MOD_CONTROL) == 0)
    return;
  const ImVec2 a(float(drag_->from.x), float(drag_->from.y)), b(float(drag_->last.x), float(drag_->last.y));
  ImGui::GetForegroundDrawList()->AddRect(a, b, ImGui::GetColorU32({1.0f, 0.6f, 0.1f, 1.0f}), 0.0f, 0, 2.0f);
}

void Viewer::fly(double seconds) {
  if (!session_ || export_ || gui_.has_text_cursor()) return;
  const auto key = [&](int name) { return held_.contains(name) ? 1.0 : 0.0; };
  if (key(GLFW_KEY_LEFT_CONTROL) + key(GLFW_KEY_RIGHT_CONTROL) + key(GLFW_KEY_LEFT_ALT) > 0.0) return;
  const core::dvec3 move(key(GLFW_KEY_D) - key(GLFW_KEY_A), key(GLFW_KEY_W) - key(GLFW_KEY_S),
                         key(GLFW_KEY_E) - key(GLFW_KEY_Q));
  const bool falls = walker_ && walker_->falling() && !drag_;
  if (move == core::dvec3(0.0) && !falls) return;
  const bool fast = held_.contains(GLFW_KEY_LEFT_SHIFT) || held_.contains(GLFW_KEY_RIGHT_SHIFT);
  if (walker_) return walk((fast ? kFasterOnFoot : 1.0) * move, seconds);
  session_->camera().fly(move, seconds * (fast ? kFaster : 1.0));
}

void Viewer::set_walking(bool walking) {
  walker_.reset();
  if (!walking) return;
  session_->camera().set_orthographic(false);
  walker_.emplace([this](const core::dvec3& origin, const core::dvec3& direction, double reach) {
    const auto view = session_->view();
    std::optional<double> distance;
    if (!view) return distance;
    const core::Ray ray{origin, direction, 0.0, reach};
    if (const auto hit = session_->engine().pick(ray, raytrace::filter_of(*view)); hit && *hit) distance = (*hit)->t;
    return distance;
  });
  session_->remember();
  walk({}, 0.0);
}

/// By what is held: to the right and ahead, over the ground.
void Viewer::walk(const core::dvec3& held, double seconds) {
  core::Pose pose = session_->camera().pose();
  const core::dvec3 sight = pose.target - pose.eye;
  core::dvec2 ahead(sight.x, sight.y);
  if (glm::length(ahead) == 0.0) ahead = core::dvec2(pose.up.x, pose.up.y);  // straight up or down
  ahead /= std::max(glm::length(ahead), 1e-300);
  const core::dvec2 velocity = Walker::kSpeed * (held.y * ahead + held.x * core::dvec2(ahead.y, -ahead.x));
  pose.eye = walker_->move(pose.eye, velocity, seconds);
  pose.target = pose.eye + sight;
  session_->camera().set_pose(pose);
}

/// Finds what is under the resting cursor, also while keys move the camera.
void Viewer::hover() {
  if (!session_ || drag_ || export_ || session_->engine().preparing_picks()) return;
  if (click_) click(*std::exchange(click_, std::nullopt));
  // What was there may be hidden now, or elsewhere in the image.
  const std::uint64_t version = session_->document().version();
  bool changed = std::exchange(hovered_version_, version) != version;
  if (const auto view = session_->view(); view && !(hovered_view_ && core::same_image(*view, *hovered_view_))) {
    hovered_view_ = *view;
    changed = true;
  }
  if (!std::exchange(cursor_moved_, false) && !changed) return;
  std::optional<core::ItemId> item;
  const bool over_image =
      in_viewport(cursor_) && !ImGui::GetIO().WantCaptureMouse && !triad_end() && !section_target() && !over_slider();
  aimed_.reset();
  cursor_point_.reset();
  if (over_image && shown.tool == Tool::kMeasure) {
    if (const auto aimed = session_->aim(in_image(cursor_), kReach * gui_.scale()); aimed && *aimed) {
      aimed_ = (*aimed)->snap;
      cursor_point_ = aimed_->point;
    }
  } else if (over_image) {
    if (const auto hit = session_->pick(in_image(cursor_)); hit && *hit) {
      item = (*hit)->item;
      cursor_point_ = (*hit)->point;
    }
  }
  session_->document().hover(item);
}

}  // namespace sightline::apps
