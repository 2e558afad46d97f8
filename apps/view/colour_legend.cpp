// What the colours of the image mean: a small window in its upper left corner while items are coloured by an attribute,
// and in images that are written.
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include <imgui.h>

#include "sightline/apps/common/short_text.h"
#include "sightline/apps/view/overlay.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

constexpr float kWidestLines = 16.0f, kMostShare = 0.45f;  // of a label, in lines of text; of the image's width

void select_group(Workspace& work, std::size_t group) {
  const std::vector<std::uint8_t>& of_item = work.session->colouring.of_item;
  std::vector<core::ItemId> items;
  for (std::size_t i = 0; i < of_item.size(); ++i)
    if (of_item[i] == group) items.push_back(core::ItemId(i));
  work.messages.tell_outcome(work.session->document.select(items));
}

std::string label_of(const query::ColourGroup& group) {
  return group.label.empty() ? "(empty)" : group.label;
}

}  // namespace

void draw_legend(const Canvas& canvas, const query::Colouring& colouring) {
  if (colouring.groups.empty()) return;
  const float line = canvas.font_pixels, pad = 0.5f * line, row = 1.25f * line, indent = 1.5f * line;
  const float widest = std::min(kWidestLines * line, kMostShare * canvas.size.x);
  const auto fitting = [&](const std::string& text) {
    return shortened_to(text, [&](std::string_view part) { return canvas.text_size(std::string(part)).x <= widest; });
  };
  const std::string key = fitting(colouring.key);
  float wide = canvas.text_size(key).x;
  std::vector<std::string> texts;
  for (const query::ColourGroup& group : colouring.groups) {
    texts.push_back(fitting(label_of(group)) + "  " + grouped(group.items));
    wide = std::max(wide, indent + canvas.text_size(texts.back()).x);
  }
  const ImVec2 from(canvas.corner.x + pad, canvas.corner.y + pad), at(from.x + pad, from.y + pad);
  canvas.list.AddRectFilled(from, {at.x + wide + pad, at.y + row * float(texts.size() + 1) + pad},
                            ImGui::ColorConvertFloat4ToU32(kShade));
  canvas.text(at, kWhite, key);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const core::vec3& colour = colouring.groups[i].colour;
    const ImVec2 corner(at.x, at.y + row * float(i + 1));
    canvas.list.AddRectFilled(corner, {corner.x + line, corner.y + line},
                              ImGui::ColorConvertFloat4ToU32({colour.r, colour.g, colour.b, 1.0f}));
    canvas.text({corner.x + indent, corner.y}, kWhite, texts[i]);
  }
}

void colour_legend(Workspace& work, const Part& part) {
  if (!work.session || work.session->colouring.groups.empty()) return;
  const query::Colouring& colouring = work.session->colouring;
  const float font = ImGui::GetFontSize(), side = ImGui::GetTextLineHeight(),
              widest = std::min(kWidestLines * font, kMostShare * float(part.width));
  ImGui::SetNextWindowPos(
      {float(part.x) + 0.5f * font, ImGui::GetIO().DisplaySize.y - float(part.y + part.height) + 0.5f * font});
  ImGui::SetNextWindowBgAlpha(0.85f);
  ImGui::Begin("##legend", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
                   ImGuiWindowFlags_NoBringToFrontOnFocus);
  ImGui::TextUnformatted(shortened(colouring.key, widest).c_str());
  for (std::size_t i = 0; i < colouring.groups.size(); ++i) {
    const query::ColourGroup& group = colouring.groups[i];
    const std::string label = label_of(group), count = grouped(group.items);
    ImGui::PushID(int(i));
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const std::string text = shortened(label, widest) + "  " + count;
    if (ImGui::Selectable("##group", false, 0, {side * 1.5f + ImGui::CalcTextSize(text.c_str()).x, side}))
      select_group(work, i);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s\n%s items: a click selects them", label.c_str(), count.c_str());
    ImGui::GetWindowDrawList()->AddRectFilled(
        at, {at.x + side, at.y + side}, ImGui::GetColorU32({group.colour.r, group.colour.g, group.colour.b, 1.0f}));
    ImGui::SameLine(0.0f, 0.0f);
    ImGui::SetCursorScreenPos({at.x + 1.5f * side, at.y});
    ImGui::TextUnformatted(text.c_str());
    ImGui::PopID();
  }
  ImGui::End();
}

}  // namespace sightline::apps
