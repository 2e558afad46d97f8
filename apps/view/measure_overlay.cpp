// Marks and distances over the image.
#include <algorithm>

#include <imgui.h>

#include "sightline/apps/view/panels.h"

namespace sightline::apps {
namespace {

constexpr float kMarkRadius = 5.0f;

/// Pixels of the window from its upper left corner; none behind the eye.
std::optional<ImVec2> on_screen(const core::View& view, const Part& part, double window_height,
                                const core::dvec3& point) {
  const core::dvec4 clip = view.clip_from_world() * core::dvec4(point, 1.0);
  if (!(clip.w > 0.0)) return std::nullopt;
  const core::dvec2 at = core::dvec2(clip.x, clip.y) / clip.w;
  return ImVec2(float(part.x + 0.5 * (at.x + 1.0) * part.width),
                float(window_height - part.y - 0.5 * (at.y + 1.0) * part.height));
}

}  // namespace

void measure_overlay(Viewer& viewer, const Part& part) {
  Session* session = viewer.session();
  if (!session || (viewer.shown.tool != Tool::kMeasure && !session->measuring().distance())) return;
  const auto view = session->view();
  if (!view) return;
  const double height = double(ImGui::GetIO().DisplaySize.y);
  ImDrawList& list = *ImGui::GetBackgroundDrawList();  // below panels, menus and dialogs
  const ImU32 colour = ImGui::GetColorU32({0.95f, 0.45f, 0.05f, 1.0f}), shade = ImGui::GetColorU32({0, 0, 0, 0.75f});
  const auto screen = [&](const core::dvec3& point) { return on_screen(*view, part, height, point); };
  const auto text = [&](ImVec2 at, const std::string& words) {
    const ImVec2 size = ImGui::CalcTextSize(words.c_str());
    at.x = std::max(float(part.x), std::min(at.x, float(part.x + part.width) - size.x - 6.0f));  // not over the panels
    list.AddRectFilled({at.x - 3.0f, at.y - 2.0f}, {at.x + size.x + 3.0f, at.y + size.y + 2.0f}, shade);
    list.AddText(at, ImGui::GetColorU32({1, 1, 1, 1}), words.c_str());
  };
  const Measuring& measuring = session->measuring();
  if (const auto& distance = measuring.distance()) {
    const auto from = screen(distance->from), to = screen(distance->to);
    if (from && to) {
      list.AddLine(*from, *to, colour, 2.0f);
      text({0.5f * (from->x + to->x) + 8.0f, 0.5f * (from->y + to->y)}, viewer.lengths().text(distance->distance));
    }
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
