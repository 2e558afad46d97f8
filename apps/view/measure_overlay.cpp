// Marks and distances over the image.
#include <algorithm>

#include <imgui.h>

#include "sightline/apps/view/overlay.h"
#include "sightline/apps/view/panels.h"

namespace sightline::apps {
namespace {

constexpr float kMarkRadius = 5.0f;

}  // namespace

void measure_overlay(Viewer& viewer, const Part& part) {
  Session* session = viewer.session();
  if (!session || (viewer.shown.tool != Tool::kMeasure && session->measuring().list().empty())) return;
  const auto view = session->view();
  if (!view) return;
  Overlay overlay(*view, part);
  ImDrawList& list = overlay.list();
  const ImU32 colour = ImGui::GetColorU32({0.95f, 0.45f, 0.05f, 1.0f}), shade = ImGui::GetColorU32({0, 0, 0, 0.75f});
  const auto screen = [&](const core::dvec3& point) { return overlay.at(point); };
  const auto text = [&](ImVec2 at, const std::string& words) {
    const ImVec2 size = ImGui::CalcTextSize(words.c_str());
    at.x = std::max(float(part.x), std::min(at.x, float(part.x + part.width) - size.x - 6.0f));  // not over the panels
    list.AddRectFilled({at.x - 3.0f, at.y - 2.0f}, {at.x + size.x + 3.0f, at.y + size.y + 2.0f}, shade);
    list.AddText(at, ImGui::GetColorU32({1, 1, 1, 1}), words.c_str());
  };
  const Measuring& measuring = session->measuring();
  for (const Measurement& one : measuring.list()) {
    const auto from = screen(one.from), to = screen(one.to);
    overlay.line(one.from, one.to, colour, 2.0f);
    if (from && to)
      text({0.5f * (from->x + to->x) + 8.0f, 0.5f * (from->y + to->y)}, viewer.lengths().text(one.distance()));
  }
  for (const Measuring::Mark& mark : measuring.marks())
    if (const auto at = screen(mark.snap.point)) list.AddCircle(*at, kMarkRadius, colour, 0, 2.0f);
  if (viewer.shown.tool != Tool::kMeasure || !viewer.aimed()) return;
  if (const auto at = screen(viewer.aimed()->point)) {
    list.AddCircleFilled(*at, kMarkRadius, colour);
    text({at->x + 12.0f, at->y - 24.0f}, viewer.aimed()->words);
  }
}

}  // namespace sightline::apps
