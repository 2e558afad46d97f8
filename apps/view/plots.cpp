#include "sightline/apps/view/plots.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sightline::apps {
namespace {

/// Beside what comes before, or below it where that leaves no room.
void legend(const Curve& curve) {
  const float font = ImGui::GetFontSize(), gap = 0.8f * font,
              width = gap + 1.1f * font + ImGui::CalcTextSize(curve.name).x;
  if (ImGui::GetItemRectMax().x + width < ImGui::GetWindowPos().x + ImGui::GetContentRegionMax().x)
    ImGui::SameLine(0.0f, gap);
  colour_square(curve.colour);
  ImGui::TextUnformatted(curve.name);
}

}  // namespace

void colour_square(const ImVec4& colour, float lower) {
  const float side = 0.7f * ImGui::GetFontSize();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float top = at.y + lower + 0.5f * (ImGui::GetTextLineHeight() - side);
  ImGui::GetWindowDrawList()->AddRectFilled({at.x, top}, {at.x + side, top + side},
                                            ImGui::ColorConvertFloat4ToU32(colour));
  ImGui::Dummy({side, ImGui::GetTextLineHeight()});
  ImGui::SameLine(0.0f, 0.4f * ImGui::GetFontSize());
}

void plot(const char* title, const std::function<std::string(double)>& words, std::size_t count,
          std::initializer_list<Curve> curves) {
  const auto has_value = [count](const Curve& curve) {
    for (std::size_t i = 0; i < count; ++i)
      if (!std::isnan(curve.value(i))) return true;
    return false;
  };
  double most = -std::numeric_limits<double>::infinity();
  for (const Curve& curve : curves)
    for (std::size_t i = 0; i < count; ++i)
      if (const double value = curve.value(i); value > most) most = value;
  if (!std::isfinite(most)) return;
  ImGui::Text("%s, up to %s", title, words(most).c_str());
  if (curves.size() > 1)
    for (const Curve& curve : curves)
      if (has_value(curve)) legend(curve);
  const ImVec2 low = ImGui::GetCursorScreenPos();
  const ImVec2 size{std::max(1.0f, ImGui::GetContentRegionAvail().x), 2.6f * ImGui::GetFontSize()};
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(low, {low.x + size.x, low.y + size.y}, ImGui::GetColorU32(ImGuiCol_FrameBg));
  const float step = size.x / float(std::max<std::size_t>(2, count) - 1);
  const auto place = [&](std::size_t i, double value) {
    const double share = most > 0.0 ? value / most : 0.0;
    return ImVec2(low.x + step * float(i), low.y + size.y - 1.0f - float(share) * (size.y - 2.0f));
  };
  for (const Curve& curve : curves) {
    const ImU32 colour = ImGui::ColorConvertFloat4ToU32(curve.colour);
    for (std::size_t i = 0; i < count; ++i) {
      const double value = curve.value(i);
      if (std::isnan(value)) continue;
      const double next = i + 1 < count ? curve.value(i + 1) : std::numeric_limits<double>::quiet_NaN();
      const ImVec2 at = place(i, value);
      if (std::isnan(next))
        list.AddRectFilled({at.x - 1.0f, at.y - 1.0f}, {at.x + 1.0f, at.y + 1.0f}, colour);
      else
        list.AddLine(at, place(i + 1, next), colour, 1.5f);
    }
  }
  ImGui::Dummy(size);
}

}  // namespace sightline::apps
