// What the window shows while no model is open: how to open one, and how to move in it.
#include <algorithm>
#include <filesystem>
#include <string>

#include <imgui.h>

#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

/// Name and folder of files opened before; a click opens one again.
void recent_models(Viewer& viewer) {
  if (viewer.recent().empty()) return;
  ImGui::TextDisabled("Recent models");
  std::string chosen;
  for (const std::string& file : viewer.recent()) {
    const std::filesystem::path path(file);
    const bool there = viewer.file_states().of(file).there;
    ImGui::PushID(file.c_str());
    const float x = ImGui::GetCursorPosX(), wide = ImGui::GetContentRegionAvail().x;
    if (ImGui::Selectable("##file", false, there ? 0 : ImGuiSelectableFlags_Disabled)) chosen = file;
    if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
      ImGui::SetTooltip("%s%s", file.c_str(), there ? "" : "\nno longer there");
    ImGui::SameLine(x);
    const std::string name = shortened(path.filename().string(), 0.47f * wide);
    there ? ImGui::TextUnformatted(name.c_str()) : ImGui::TextDisabled("%s", name.c_str());
    ImGui::SameLine(x + 0.5f * wide);
    ImGui::TextDisabled("%s", shortened(path.parent_path().string(), 0.5f * wide).c_str());
    ImGui::PopID();
  }
  if (!chosen.empty()) viewer.open({chosen});
}

void first_gestures() {
  constexpr std::size_t kFirst = 4;  // turning, moving, looking, coming nearer
  ImGui::TextDisabled("In the model");
  if (!begin_rows("gestures")) return;
  for (const Gesture& gesture : gestures().first(kFirst)) row(gesture.how, gesture.what);
  row("F1", "all keys and mouse");
  ImGui::EndTable();
}

}  // namespace

void start_page(Viewer& viewer, const apps::Part& part) {
  if (viewer.session() || viewer.loader()) return;
  const float font = ImGui::GetFontSize(), top = ImGui::GetIO().DisplaySize.y - float(part.y + part.height),
              wide = std::min(float(part.width), 40.0f * font);
  ImGui::PushStyleColor(ImGuiCol_Border, {0.0f, 0.0f, 0.0f, 0.0f});
  begin_fixed("##start", float(part.x) + 0.5f * (float(part.width) - wide), top, wide, float(part.height),
              ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoBackground);
  ImGui::Dummy({0.0f, std::max(0.0f, 0.12f * float(part.height))});
  const Command& open = *find_command("open");
  const std::string title = std::string(open.title) + "  " + open.keys;
  if (ImGui::Button(title.c_str(), {12.0f * font, 2.2f * font})) run(viewer, open);
  if (wide > 20.0f * font) {
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
  }
  wrapped_text("or drop files on the window");
  ImGui::Dummy({0.0f, font});
  recent_models(viewer);
  ImGui::Dummy({0.0f, font});
  first_gestures();
  ImGui::End();
  ImGui::PopStyleColor();
}

}  // namespace sightline::apps
