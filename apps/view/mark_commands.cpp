// What draws mark-ups: the mouse, and commands.
#include <string_view>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/marking.h"

namespace sightline::apps {
namespace {

constexpr const char* kWordsToCome = "…";  // of a text whose words are still to be written

/// Between two places of the window, on a plane through a point.
core::Expected<Markup> markup_between(const Workspace& work, const AskedMarkup& asked, const core::dvec3& through) {
  const Session& session = *work.session;
  const auto view = session.image.view();
  if (!view) return tl::unexpected(view.error());
  return drawn_markup(asked.kind, asked.words, {*view, session.image.size(), through}, work.image.in_image(asked.from),
                      work.image.in_image(asked.to));
}

Done draw(Workspace& work, const AskedMarkup& asked, const core::dvec3& through) {
  return markup_between(work, asked, through).map([&](Markup&& markup) {
    work.session->marking.add(std::move(markup));
  });
}

/// The words come from the tab, before or after.
void draw_by_mouse(Workspace& work, const core::dvec2& from, const core::dvec2& to, const core::dvec3& through) {
  Marking& marking = work.session->marking;
  const auto put = [&](Markup&& made) {
    if (made.kind == Markup::Kind::kText) work.shown.tab = "Mark up", work.shown.panels = true;
    marking.draw(std::move(made), work.shown.panels && work.shown.tab == std::string_view("Mark up"));
  };
  work.messages.tell_outcome(markup_between(work, {marking.kind, from, to, kWordsToCome}, through).map(put));
}

}  // namespace

Done mark(Workspace& work, const std::string& argument) {
  if (argument.empty()) {
    work.shown.tool = work.shown.tool == Tool::kMark ? Tool::kSelect : Tool::kMark;
    if (work.shown.tool == Tool::kMark) work.shown.tab = "Mark up";
    return {};
  }
  return parse_markup(argument).and_then([&](const AskedMarkup& asked) {
    return draw(work, asked, work.session->point_at(work.image.in_image(asked.from)));
  });
}

Done remove_markup(const std::string& number, Session& session) {
  Marking& marking = session.marking;
  return numbered("mark-up", number, marking.list().size()).map([&](std::size_t i) { marking.remove(i); });
}

bool draws_markup(const Workspace& work, const Gestures::Drag& drag) {
  return work.session && work.shown.tool == Tool::kMark && work.session->marking.kind != Markup::Kind::kText &&
         drag.button == GLFW_MOUSE_BUTTON_LEFT && drag.mods == 0;
}

core::Expected<Markup> markup_of(const Workspace& work, const Gestures::Drag& drag) {
  const Marking& marking = work.session->marking;
  return markup_between(work, {marking.kind, drag.from, drag.last, marking.next_words()}, drag.point);
}

void mark_dragged(Workspace& work, const Gestures::Drag& drag) {
  draw_by_mouse(work, drag.from, drag.last, drag.point);
}

void mark_clicked(Workspace& work, const core::dvec2& at) {
  if (work.session->marking.kind != Markup::Kind::kText) return work.messages.tell("drag: an arrow begins at its tip");
  draw_by_mouse(work, at, at, work.session->point_at(work.image.in_image(at)));
}

}  // namespace sightline::apps
