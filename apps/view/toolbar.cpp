// The row of buttons below the menu bar: all commands with an icon, in the order of their menus, and beside that which
// selects, what clicks select.
#include <algorithm>
#include <string>
#include <string_view>

#include <imgui.h>

#include "sightline/apps/view/icons.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

constexpr float kIconLines = 1.2f, kPaddingLines = 0.25f, kGapLines = 0.45f;  // in lines of text

float button_side() {
  return (kIconLines + 2.0f * kPaddingLines) * ImGui::GetFontSize();
}

constexpr std::string_view kSelects = "select";  // the command

/// Grey where the command is impossible, pressed where it is on. The tooltip says what it does, or what it lacks.
void button(Workspace& work, const Command& command) {
  const float side = button_side(), padding = kPaddingLines * ImGui::GetFontSize();
  const char* obstacle = command.obstacle_now(work);
  const bool on = !obstacle && command.on && command.on(work);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::BeginDisabled(obstacle != nullptr);
  if (ImGui::InvisibleButton(command.name, {side, side})) run(work, command);
  ImGui::EndDisabled();
  const bool hovered = ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  if (on || (hovered && !obstacle)) {
    const ImGuiCol ground = ImGui::IsItemActive() ? ImGuiCol_ButtonActive
                            : on                  ? ImGuiCol_Button
                                                  : ImGuiCol_FrameBgHovered;
    list.AddRectFilled(at, {at.x + side, at.y + side}, ImGui::GetColorU32(ground), ImGui::GetStyle().FrameRounding);
  }
  draw_icon(list, command.icon, {at.x + padding, at.y + padding}, kIconLines * ImGui::GetFontSize(),
            ImGui::GetColorU32(obstacle ? ImGuiCol_TextDisabled : ImGuiCol_Text, obstacle ? 0.6f : 1.0f));
  if (hovered) command_tip(work, command, true);
}

constexpr const char* kLevelCommands[] = {"level-item", "level-part", "level-assembly", "level-file"};

float level_width() {
  float widest = 0.0f;
  for (const char* name : kLevelCommands) widest = std::max(widest, ImGui::CalcTextSize(find_command(name)->title).x);
  return widest + 2.0f * ImGui::GetStyle().FramePadding.x + button_side();
}

/// A list of what clicks may select.
void level_list(Workspace& work) {
  const ImGuiStyle& style = ImGui::GetStyle();
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding,
                      {style.FramePadding.x, 0.5f * (button_side() - ImGui::GetFontSize())});
  ImGui::SetNextItemWidth(level_width());
  const bool open = ImGui::BeginCombo("##level", find_command(kLevelCommands[int(work.shown.level)])->title);
  ImGui::PopStyleVar();
  if (!open && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", "What clicks select");
  if (!open) return;
  for (const char* name : kLevelCommands) command_item(work, *find_command(name));
  ImGui::EndCombo();
}

/// What has no room in a narrow window.
void overflow(Workspace& work, std::span<const Command> left) {
  if (ImGui::Button("»", {0.0f, button_side()})) ImGui::OpenPopup("##more");
  if (!ImGui::BeginPopup("##more")) return;
  for (const Command& command : left) {
    if (command.icon) command_item(work, command);
    if (command.name != kSelects) continue;
    for (const char* name : kLevelCommands) command_item(work, *find_command(name));
  }
  ImGui::EndPopup();
}

}  // namespace

float toolbar_height() {
  return button_side() + 2.0f * ImGui::GetStyle().FramePadding.y;
}

void toolbar(Workspace& work) {
  const ImGuiStyle& style = ImGui::GetStyle();
  const float wide = ImGui::GetIO().DisplaySize.x, more = 2.0f * ImGui::GetFontSize();
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {style.WindowPadding.x, style.FramePadding.y});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1.0f, 1.0f});
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {1.0f, 1.0f});
  begin_fixed("##toolbar", 0.0f, ImGui::GetFrameHeight(), wide, toolbar_height(),
              ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  const std::span<const Command> all = commands();
  std::string_view menu;
  bool first = true;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!all[i].icon) continue;
    const std::string_view its = MenuPlace(all[i]).menu;
    if (!first) ImGui::SameLine(0.0f, its == menu ? style.ItemSpacing.x : kGapLines * ImGui::GetFontSize());
    first = false;
    menu = its;
    const float own = all[i].name == kSelects ? button_side() + level_width() : button_side();
    if (ImGui::GetCursorPosX() + own + more > wide) {
      overflow(work, all.subspan(i));
      break;
    }
    button(work, all[i]);
    if (all[i].name != kSelects) continue;
    ImGui::SameLine();
    level_list(work);
  }
  ImGui::End();
  ImGui::PopStyleVar(3);
}

}  // namespace sightline::apps
