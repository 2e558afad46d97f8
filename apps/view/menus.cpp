// The menu bar and the menu of the right mouse button, out of the table of commands.
#include <filesystem>
#include <string>
#include <string_view>

#include <imgui.h>

#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/tree_rows.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

void recent_files(Workspace& work) {
  if (!ImGui::BeginMenu("Open recent", !work.shown.recent.empty())) return;
  for (const std::string& file : work.shown.recent) {
    if (ImGui::MenuItem(std::filesystem::path(file).filename().string().c_str())) work.open({file});
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", file.c_str());
  }
  ImGui::EndMenu();
}

/// The commands of one menu. Those of a submenu stand beside each other in the table.
void menu_items(Workspace& work, std::string_view menu) {
  std::string_view submenu;
  bool open = true, first = true;
  for (const Command& command : commands()) {
    const MenuPlace place(command);
    if (place.menu != menu) continue;
    if (place.submenu != submenu) {
      if (!submenu.empty() && open) ImGui::EndMenu();
      submenu = place.submenu;
      if (place.begins_block) ImGui::Separator();
      open = submenu.empty() || ImGui::BeginMenu(std::string(submenu).c_str());
    } else if (place.begins_block && open && !first) {
      ImGui::Separator();
    }
    first = false;
    if (!open) continue;
    command_item(work, command);
    if (command.name == std::string_view("open")) recent_files(work);
  }
  if (!submenu.empty() && open) ImGui::EndMenu();
}

std::string name_of_selection(const Session& session) {
  const auto selection = session.document.selection();
  if (selection.empty()) return "nothing selected";
  if (selection.size() > 1) return grouped(std::int64_t(selection.size())) + " items selected";
  return shortened(item_name(session.scene(), selection[0]), 24.0f * ImGui::GetFontSize());
}

}  // namespace

std::string item_name(const core::Scene& scene, core::ItemId item) {
  core::NodeId named = scene.node_of(item);
  while (named.valid() && scene.name(named).empty()) named = scene.parent(named);
  return named.valid() ? std::string(scene.name(named)) : std::string(core::name_of(scene.kind(item)));
}

void menu_bar(Workspace& work) {
  if (!ImGui::BeginMainMenuBar()) return;
  std::string_view last;
  for (const Command& command : commands()) {
    const std::string_view menu = MenuPlace(command).menu;
    if (menu.empty() || menu == last) continue;
    last = menu;
    if (!ImGui::BeginMenu(std::string(menu).c_str())) continue;
    menu_items(work, menu);
    ImGui::EndMenu();
  }
  ImGui::EndMainMenuBar();
}

void context_menu(Workspace& work) {
  constexpr const char* kName = "##context";
  if (work.shown.context) ImGui::OpenPopup(kName);
  work.shown.context = false;
  if (!work.session || !ImGui::BeginPopup(kName)) return;
  ImGui::TextDisabled("%s", name_of_selection(*work.session).c_str());
  ImGui::Separator();
  for (const char* name :
       {"select-part", "hide", "isolate", "ghost-others", "show-all", "", "focus", "fit", "camera-back", "",
        "section-at", "section-box", "section-clear", "", "measure-selected", "view-add", "export-selection", "undo"}) {
    if (name[0] == '\0')
      ImGui::Separator();
    else
      command_item(work, *find_command(name));
  }
  ImGui::EndPopup();
}

}  // namespace sightline::apps
