// A frame of the window: events, panels, and the image between them.
#include <algorithm>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>

#include "sightline/apps/view/exporting.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/viewer.h"
#include "sightline/gl/external_target.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {
namespace {

using Type = Event::Type;

constexpr core::vec3 kEmptyDark{0.11f, 0.12f, 0.13f}, kEmptyLight{0.86f, 0.88f, 0.9f};
constexpr double kLongestStep = 0.25;  // seconds: a hitch must not make the camera jump

}  // namespace

core::Expected<void> Viewer::frame(double seconds) {
  const double began = glfwGetTime();
  for (const Event& event : gui_.take_events()) {
    redraws_ = kSettlingFrames;
    if (export_) {
      export_cancelled_ |= event.type == Type::kKey && event.down && event.key == GLFW_KEY_ESCAPE;
      continue;
    }
    const bool escapes = event.type == Type::kKey && event.key == GLFW_KEY_ESCAPE && shown.dialog != Dialog::kNone;
    if (!gui_.uses(event) || event.type == Type::kDrop || (event.type == Type::kButton && !event.down) ||
        (event.type == Type::kKey && !event.down) || event.type == Type::kCursor || escapes)
      handle(event);
  }
  fly(std::min(seconds, kLongestStep));
  play();
  hover();
  const std::array<int, 2> size = window_.size();
  gui_.begin(size, seconds);
  if (shown.panels) {
    menu_bar(*this);
    toolbar(*this);
    splitters(*this);  // first: of windows that stay in their order, the one that was made first lies in front
    tree_panel(*this);
    side_panel(*this);
    status_bar(*this);
  }
  if (options_.frames == 0) start_page(*this, viewport());
  context_menu(*this);
  dialog_window(*this);
  if (loader_) loading_window(*this);
  exporting_window(*this);
  if (session_ && session_->document().hovered() && !drag_ && shown.tool == Tool::kSelect && !section_target() &&
      shown.dialog == Dialog::kNone && !gui_.has_popup() && !ImGui::GetIO().WantCaptureMouse)
    item_tip(*this, *session_->document().hovered());
  draw_rectangle();
  measure_overlay(*this, viewport());
  section_overlay(*this, viewport());
  slider_overlay(*this, viewport());
  window_.clear(gui_.theme() == Theme::kDark ? kEmptyDark : kEmptyLight);
  const auto drawn = draw_model(viewport());
  if (session_) culling_.draw(*session_, viewport());
  triad_overlay(*this);
  gui_.end();
  if (!drawn) return drawn;
  if (!window_shot_.empty()) {
    auto written = image::write_png(window_.read(), std::exchange(window_shot_, {}));
    if (!written) return written;
  }
  window_.present();
  if (textures_.end_frame()) redraws_ = std::max(redraws_, 2);
  const double now = glfwGetTime();
  frame_seconds_ = now - began;
  next_frame_ = now + kBetweenFrames * frame_seconds_;
  if (asked_at_ > 0.0) response_ms_ = 1e3 * (now - std::exchange(asked_at_, 0.0));
  if (!gui_.has_events()) asked_at_ = -1.0;
  redraws_ = std::max(0, redraws_ - 1);
  message_is_new_ = false;
  return {};
}

core::Expected<void> Viewer::draw_model(const Part& part) {
  if (part.width <= 0 || part.height <= 0) return {};
  if (!session_ && preview_) {
    const auto framebuffer = preview_->draw(window_.context(), {part.width, part.height});
    if (framebuffer) window_.copy(*framebuffer, {part.width, part.height}, part);
  }
  if (!session_) return {};
  if (export_) {
    if (!window_.keeps_image())
      if (auto done = window_.keep(&export_->before()); !done) return done;
    return window_.copy_kept(part), core::Expected<void>();
  }
  part_ = part;
  if (auto done = session_->resize({part.width, part.height}); !done) return done;
  if (auto done = adapt_to_motion(); !done) return done;
  const bool shifted = session_->partly_refined() || (session_->smooth() && !shown.smooth);
  if (options_.frames > 0 || shifted) session_->changed();
  const auto drawn = session_->draw();
  if (!drawn) return tl::unexpected(drawn.error());
  if (*drawn) note_image();
  if (auto done = show_image(part); !done || drag_) return done;
  return session_->outline_hovered({0, part.x, part.y, part.width, part.height});
}

core::Expected<void> Viewer::show_image(const Part& part) {
  keeps_moving_image_ = keeps_moving_image_ && !motion_.moving() && session_->report().pending > 0;
  if (keeps_moving_image_) return window_.copy_kept(part), core::Expected<void>();
  const image::Image* smooth = shown.smooth ? session_->smooth() : nullptr;
  core::Expected<void> copied;
  if (!smooth || !window_.keeps_image()) copied = window_.keep(smooth);
  if (smooth && copied)
    window_.copy_kept(part);
  else
    for (const Session::ImagePart& columns : session_->parts())
      window_.copy(session_->framebuffer(columns).value_or(0), session_->drawn_size(), part, columns.begin,
                   columns.end);
  return copied;
}

/// Coarser meshes while the view moves, and fewer pixels where frames then come late. With a budget the image at rest
/// takes several frames, and begins with fewer items than that of the motion, which therefore stays until then.
core::Expected<void> Viewer::adapt_to_motion() {
  const auto view = session_->view();
  const bool moves = view && shown_view_ && !core::same_image(*view, *shown_view_);
  if (view) shown_view_ = *view;
  const bool moved = motion_.moving();
  const bool coarse = motion_.next(moves, glfwGetTime(), frame_seconds_) && shown.lower && options_.frames == 0;
  if (moved && !motion_.moving() && session_->report().pending > 0) {
    const auto image = session_->engine().read_colour();
    if (!image) return tl::unexpected(image.error());
    if (auto kept = window_.keep(&*image); !kept) return kept;
    keeps_moving_image_ = true;
  }
  if (auto done = session_->set_coarse(coarse); !done) return done;
  return session_->set_moving(motion_.moving());
}

void Viewer::note_image() {
  const engine::FrameReport& report = session_->report();
  ++frames_;
  if (recorder_) recorder_->add(glfwGetTime(), {session_->camera().pose(), session_->camera().fovy()});
  if (!options_.json_file.empty()) {
    cull_ms_.push_back(report.cull_ms);
    if (report.frame_ms > 0.0) frame_ms_.push_back(report.frame_ms);
  }
  history_.add(report, session_->visible());
}

/// Where the model is drawn: between the panels.
Part Viewer::viewport() const {
  const std::array<int, 2> size = window_.size();
  if (!shown.panels) return {0, 0, size[0], size[1]};
  const Margins m = margins(*this);
  return {m.left, m.bottom, std::max(1, size[0] - m.left - m.right), std::max(1, size[1] - m.top - m.bottom)};
}

}  // namespace sightline::apps
