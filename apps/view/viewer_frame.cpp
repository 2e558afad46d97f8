// A frame of the window: events, panels, and the image between them.
#include <algorithm>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>

#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/viewer.h"
#include "sightline/gl/external_target.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {
namespace {

using Type = Event::Type;

constexpr core::vec3 kEmptyDark{0.11f, 0.12f, 0.13f}, kEmptyLight{0.86f, 0.88f, 0.9f};
constexpr double kLongestStep = 0.25;  // seconds: a hitch must not make the camera jump

/// Whether the image gets an event beside the panels.
bool reaches_image(const Event& event, const Gui& gui, const Shown& shown) {
  const bool key = event.type == Type::kKey, ends = (key || event.type == Type::kButton) && !event.down;
  const bool escapes = key && event.key == GLFW_KEY_ESCAPE && shown.dialog != Dialog::kNone;
  return !gui.uses(event) || event.type == Type::kDrop || ends || event.type == Type::kCursor || escapes;
}

}  // namespace

Done Viewer::frame(double seconds) {
  const double began = glfwGetTime();
  take_events();
  work_.gestures.fly(std::min(seconds, kLongestStep));
  play();
  work_.gestures.hover();
  work_.gui.begin(work_.window.size(), seconds);
  draw_panels();
  work_.window.clear(work_.shown.light ? kEmptyLight : kEmptyDark);
  const auto drawn = draw_model(work_.viewport());
  if (work_.session) work_.culling.draw(*work_.session, work_.viewport());
  triad_overlay(work_);
  work_.gui.end();
  if (!drawn) return drawn;
  if (const std::string shot = script_.take_window_shot(); !shot.empty())
    if (auto written = image::write_png(work_.window.read(), shot); !written) return written;
  work_.window.present();
  end_frame(began);
  return {};
}

void Viewer::take_events() {
  for (const Event& event : work_.gui.take_events()) {
    work_.pace.redraw();
    if (work_.exports.image()) {
      if (event.type == Type::kKey && event.down && event.key == GLFW_KEY_ESCAPE) work_.exports.cancel_image();
    } else if (reaches_image(event, work_.gui, work_.shown)) {
      work_.gestures.handle(event);
    }
  }
  if (work_.exports.image()) work_.gestures.let_go();
}

void Viewer::play() {
  if (!work_.session || work_.exports.image()) return;
  Camera& camera = work_.session->camera;
  const int frames = work_.options.frames;
  const auto sample = frames > 0 ? work_.player.next_frame(work_.image.frames(), frames)
                                 : work_.player.next(glfwGetTime(), camera.pose());
  if (!sample) return;
  camera.set_pose(sample->pose);
  camera.set_fovy(sample->fovy);
}

void Viewer::draw_panels() {
  if (work_.shown.panels) {
    menu_bar(work_);
    toolbar(work_);
    splitters(work_.shown);  // first: of windows that stay in their order, the one that was made first lies in front
    tree_panel(work_);
    side_panel(work_);
    status_bar(work_);
  }
  if (work_.options.frames == 0) start_page(work_, work_.viewport());
  context_menu(work_);
  dialog_window(work_);
  if (work_.opening.active()) loading_window(work_.opening, work_.messages);
  exporting_window(work_.exports);
  if (work_.session && work_.session->document.hovered && !work_.gestures.drags() &&
      work_.shown.tool == Tool::kSelect && !work_.gestures.section_target() && work_.shown.dialog == Dialog::kNone &&
      !work_.gui.has_popup() && !ImGui::GetIO().WantCaptureMouse)
    taken_tip(work_.session->scene(), *work_.session->document.hovered);
  rectangle_overlay(work_);
  measure_overlay(work_, work_.viewport());
  markup_overlay(work_, work_.viewport());
  section_overlay(work_, work_.viewport());
  slider_overlay(work_, work_.viewport());
  colour_legend(work_, work_.viewport());
}

Done Viewer::draw_model(const Part& part) {
  if (part.width <= 0 || part.height <= 0) return {};
  if (const image::Image* first = work_.opening.first_image(); first && !work_.session) {
    if (auto done = work_.window.keep(first); !done) return done;
    return work_.window.copy_kept(part), Done();
  }
  if (Preview* preview = work_.opening.preview(); preview && !work_.session) {
    const auto framebuffer = preview->draw(work_.window.context(), {part.width, part.height});
    if (framebuffer) work_.window.copy(*framebuffer, {part.width, part.height}, part);
  }
  if (!work_.session) return {};
  if (const Export* running = work_.exports.image()) {
    if (!work_.window.keeps_image())
      if (auto done = work_.window.keep(&running->before()); !done) return done;
    return work_.window.copy_kept(part), Done();
  }
  Session& session = *work_.session;
  const int before = work_.image.frames();
  work_.image.place(part);
  const auto drawn = work_.image.draw(session, work_.shown, work_.pace.frame_seconds);
  if (work_.recorder && work_.image.frames() > before)
    work_.recorder->add(glfwGetTime(), {session.camera.pose(), session.camera.fovy()});
  if (!drawn || work_.gestures.drags()) return drawn;
  return session.image.outline_hovered({0, part.x, part.y, part.width, part.height});
}

void Viewer::end_frame(double began) {
  Pace& pace = work_.pace;
  if (work_.textures.end_frame()) pace.redraws = std::max(pace.redraws, 2);
  if (work_.messages.is_new()) pace.redraw();
  work_.messages.end_frame();
  const double now = glfwGetTime();
  pace.frame_seconds = now - began;
  pace.next_frame = now + Pace::kBetweenFrames * pace.frame_seconds;
  if (pace.asked_at > 0.0) pace.response_ms = 1e3 * (now - std::exchange(pace.asked_at, 0.0));
  if (!work_.gui.has_events()) pace.asked_at = -1.0;
  pace.redraws = std::max(0, pace.redraws - 1);
}

}  // namespace sightline::apps
