// The slider of a comparison over the image: its line, and the names of both files.
#include <algorithm>
#include <string>

#include <imgui.h>

#include "sightline/apps/view/overlay.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

constexpr float kGripLines = 0.5f, kMarginLines = 0.5f, kLineLines = 0.2f;  // in lines of text

/// Which revision it is, in the upper corner of its half, and not beyond that.
void name(ImDrawList& list, const char* which, const std::string& file, float begin, float end, float top,
          bool at_end) {
  const float font = ImGui::GetFontSize(), margin = kMarginLines * font, padding = 0.3f * font;
  const float room = end - begin - 2.0f * margin - ImGui::CalcTextSize(which).x;
  const std::string text = which + shortened(file, std::max(0.0f, room));
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  const float x = at_end ? std::max(begin + margin, end - margin - size.x) : begin + margin, y = top + margin;
  list.PushClipRect({begin, top}, {end, y + size.y + margin}, true);
  list.AddRectFilled({x - padding, y - padding}, {x + size.x + padding, y + size.y + padding},
                     ImGui::GetColorU32({0, 0, 0, 0.75f}), padding);
  list.AddText({x, y}, ImGui::GetColorU32({1, 1, 1, 1}), text.c_str());
  list.PopClipRect();
}

}  // namespace

void slider_overlay(Viewer& viewer, const Part& part) {
  const Session* session = viewer.session();
  if (!session || !session->slider()) return;
  const auto view = session->view();
  if (!view) return;
  Overlay overlay(*view, part);
  ImDrawList& list = overlay.list();
  const float font = ImGui::GetFontSize(), left = float(part.x), right = float(part.x + part.width),
              top = ImGui::GetIO().DisplaySize.y - float(part.y + part.height),
              x = left + float(session->parts().front().end) / float(session->drawn_size()[0]) * float(part.width),
              middle = top + 0.5f * float(part.height), grip = kGripLines * font;
  const bool held = viewer.over_slider();
  const ImU32 shade = ImGui::GetColorU32({0, 0, 0, 0.6f}),
              colour = held ? ImGui::GetColorU32({1.0f, 0.6f, 0.1f, 1.0f}) : ImGui::GetColorU32({1, 1, 1, 1});
  const float wide = std::max(1.0f, kLineLines * font);
  list.AddLine({x, top}, {x, top + float(part.height)}, shade, wide + 2.0f);
  list.AddLine({x, top}, {x, top + float(part.height)}, colour, wide);
  for (const float side : {-1.0f, 1.0f}) {  // arrows to both sides
    const ImVec2 a(x + side * 0.6f * grip, middle - grip), b(x + side * 0.6f * grip, middle + grip),
        tip(x + side * 1.8f * grip, middle);
    list.AddTriangleFilled(a, b, tip, colour);
    list.AddTriangle(a, b, tip, shade);
  }
  if (held) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  const auto [older, newer] = names_apart(session->changes()->file(), viewer.files());
  name(list, "older: ", older, left, x, top, false);
  name(list, "newer: ", newer, x, right, top, true);
}

}  // namespace sightline::apps
