// Draws the axes in a corner of the image.
#include <imgui.h>

#include "sightline/apps/view/panels.h"

namespace sightline::apps {
namespace {

constexpr const char* kLetters[] = {"X", "Y", "Z"};
constexpr float kLetterPixels = 14.0f, kAxisPixels = 2.5f, kFarther = 0.85f;
constexpr core::vec3 kColours[] = {{0.93f, 0.33f, 0.28f}, {0.45f, 0.75f, 0.2f}, {0.35f, 0.6f, 1.0f}};

ImVec2 pixels(const core::dvec2& at) {
  return {float(at.x), float(at.y)};
}

ImU32 colour_of(const AxisTriad::End& end, float brightness, float alpha) {
  const core::vec3 c = kColours[end.axis] * brightness;
  return ImGui::GetColorU32({c.r, c.g, c.b, alpha});
}

}  // namespace

void triad_overlay(Viewer& viewer) {
  const auto triad = viewer.triad();
  if (!triad) return;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float scale = float(triad->scale()), radius = float(triad->end_radius());
  const bool dark = viewer.gui().theme() == Theme::kDark;
  const ImU32 ink = ImGui::GetColorU32({0.04f, 0.04f, 0.04f, 1.0f});
  const ImU32 ground = ImGui::GetColorU32(dark ? ImVec4{0.1f, 0.1f, 0.11f, 0.6f} : ImVec4{1.0f, 1.0f, 1.0f, 0.65f});
  list.AddCircleFilled(pixels(triad->centre()), float(AxisTriad::reach(triad->scale())), ground);
  const auto aimed = viewer.triad_end();
  for (const AxisTriad::End& end : triad->ends()) {
    const ImVec2 at = pixels(end.at);
    const float brightness = end.depth < 0.0 ? kFarther : 1.0f;
    if (end.positive) {
      list.AddLine(pixels(triad->centre()), at, colour_of(end, brightness, 1.0f), kAxisPixels * scale);
      list.AddCircleFilled(at, radius, colour_of(end, brightness, 1.0f));
      const float size = kLetterPixels * scale;
      const ImVec2 text = ImGui::GetFont()->CalcTextSizeA(size, FLT_MAX, 0.0f, kLetters[end.axis]);
      list.AddText(ImGui::GetFont(), size, {at.x - 0.5f * text.x, at.y - 0.5f * text.y}, ink, kLetters[end.axis]);
    } else {
      list.AddCircleFilled(at, 0.75f * radius, colour_of(end, 0.5f * brightness, 0.8f));
      list.AddCircle(at, 0.75f * radius, colour_of(end, brightness, 1.0f), 0, 1.5f * scale);
    }
    if (aimed && aimed->axis == end.axis && aimed->positive == end.positive)
      list.AddCircle(at, radius + scale, ImGui::GetColorU32(ImGuiCol_Text), 0, 2.0f * scale);
  }
}

}  // namespace sightline::apps
