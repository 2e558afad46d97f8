// Marks and distances over the image.
#include <optional>
#include <string>

#include <imgui.h>

#include "sightline/apps/common/label_placement.h"
#include "sightline/apps/view/overlay.h"
#include "sightline/apps/view/panels.h"

namespace sightline::apps {
namespace {

constexpr float kMarkRadius = 5.0f, kPadding = 3.0f, kWide = 2.0f;  // pixels of a screen of usual density

}  // namespace

void measure_overlay(Viewer& viewer, const Part& part) {
  Session* session = viewer.session();
  if (!session || (viewer.shown.tool != Tool::kMeasure && session->measuring().list().empty())) return;
  const auto view = session->view();
  if (!view) return;
  Overlay overlay(*view, part);
  ImDrawList& list = overlay.list();
  const float scale = float(viewer.gui().scale()), radius = scale * kMarkRadius, padding = scale * kPadding,
              wide = scale * kWide;
  const ImU32 colour = ImGui::GetColorU32({0.95f, 0.45f, 0.05f, 1.0f}), shade = ImGui::GetColorU32({0, 0, 0, 0.75f});
  const auto screen = [&](const core::dvec3& point) { return overlay.at(point); };
  const Measuring& measuring = session->measuring();
  const double left = part.x, top = double(ImGui::GetIO().DisplaySize.y) - part.y - part.height;
  LabelPlacement labels({left, top, left + part.width, top + part.height});  // not over the panels
  const auto mark = [&](const ImVec2& at) {
    labels.add_mark({double(at.x - radius), double(at.y - radius), double(at.x + radius), double(at.y + radius)});
  };
  const auto text = [&](const ImVec2& at, const std::string& words) {
    const ImVec2 size = ImGui::CalcTextSize(words.c_str());
    const Rectangle place =
        labels.place(double(at.x), double(at.y), double(size.x + 2.0f * padding), double(size.y + 2.0f * padding));
    const ImVec2 from(float(place.left), float(place.top)), to(float(place.right), float(place.bottom));
    list.AddRectFilled(from, to, shade);
    list.AddText({from.x + padding, from.y + padding}, ImGui::GetColorU32({1, 1, 1, 1}), words.c_str());
  };
  for (const Measuring::Mark& one : measuring.marks())
    if (const auto at = screen(one.snap.point)) {
      list.AddCircle(*at, radius, colour, 0, wide);
      mark(*at);
    }
  const auto aimed =
      viewer.shown.tool == Tool::kMeasure && viewer.aimed() ? screen(viewer.aimed()->point) : std::optional<ImVec2>();
  if (aimed) {
    list.AddCircleFilled(*aimed, radius, colour);
    mark(*aimed);
  }
  for (const Measurement& one : measuring.list()) {
    const auto from = screen(one.from), to = screen(one.to);
    overlay.line(one.from, one.to, colour, wide);
    if (from && to) text({0.5f * (from->x + to->x), 0.5f * (from->y + to->y)}, viewer.lengths().text(one.distance()));
  }
  if (aimed) text(*aimed, viewer.aimed()->words);
}

}  // namespace sightline::apps
