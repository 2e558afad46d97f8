#include "sightline/apps/view/panels.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <imgui.h>

#include "sightline/apps/view/commands.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

constexpr float kTreeWidth = 19.0f, kSideWidth = 21.0f, kLeastWidth = 8.0f;  // in lines of text
constexpr float kTreeShare = 0.27f, kSideShare = 0.33f, kMostShare = 0.45f;  // of the window
constexpr float kGrip = 0.4f;                                                // lines, of an edge that can be dragged

float bar_height() {
  return ImGui::GetFrameHeight();
}

/// The width of a panel, pixels. `chosen`: by the user, in lines of text; 0: not chosen.
float panel_width(float chosen, float usual, float usual_share) {
  const float font = ImGui::GetFontSize(), wide = ImGui::GetIO().DisplaySize.x;
  if (chosen == 0.0f) return std::min(usual * font, usual_share * wide);
  return std::min(std::max(chosen, kLeastWidth) * font, kMostShare * wide);
}

/// A panel's vertical edge at `x`, held within the panel, which lies to the left or right of it: the image has
/// handles of its own. Pixels by which it is dragged to the right.
float drag_edge(const char* name, float x, float y, float height, bool panel_left) {
  const float grip = std::max(2.0f, kGrip * ImGui::GetFontSize());
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.0f, 0.0f});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1.0f, 1.0f});
  begin_fixed(name, panel_left ? x - grip : x, y, grip, height,
              ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoScrollbar);
  ImGui::InvisibleButton("##edge", {grip, height});
  const bool dragged = ImGui::IsItemActive();
  if (dragged || ImGui::IsItemHovered()) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  ImGui::End();
  ImGui::PopStyleVar(2);
  return dragged ? ImGui::GetIO().MouseDelta.x : 0.0f;
}

struct Tab {
  const char* name;
  void (*draw)(Workspace&);
};

/// The names of all, in as many rows as they need, where ImGui's tab bar would cut them off. Returns the one in front.
const Tab& tab_rows(Workspace& work, const std::vector<Tab>& all) {
  const ImGuiStyle& style = ImGui::GetStyle();
  const float right = ImGui::GetCursorScreenPos().x + ImGui::GetContentRegionAvail().x;
  const auto in_front = [&](const Tab& tab) { return std::string_view(work.shown.tab) == tab.name; };
  if (std::none_of(all.begin(), all.end(), in_front)) work.shown.tab = all.front().name;
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, style.ItemInnerSpacing);
  for (const Tab& tab : all) {
    if (&tab != &all.front()) {
      ImGui::SameLine();
      const float wide = ImGui::CalcTextSize(tab.name).x + 2.0f * style.FramePadding.x;
      if (ImGui::GetCursorScreenPos().x + wide > right) ImGui::NewLine();
    }
    ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(in_front(tab) ? ImGuiCol_TabActive : ImGuiCol_Tab));
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, ImGui::GetStyleColorVec4(ImGuiCol_TabHovered));
    if (ImGui::Button(tab.name)) work.shown.tab = tab.name;
    ImGui::PopStyleColor(2);
  }
  ImGui::PopStyleVar();
  ImGui::Separator();
  return *std::find_if(all.begin(), all.end(), in_front);
}

void tabs(Workspace& work) {
  static const ChangeList* known = nullptr;
  const ChangeList* changes = work.session->changes();
  if (std::exchange(known, changes) != changes && changes) work.shown.tab = "Compare";
  std::vector<Tab> all{{"Item", properties_tab}, {"Attributes", attributes_tab}, {"Measure", measure_tab},
                       {"Mark up", mark_tab},    {"Sections", sections_tab},     {"Views", views_tab}};
  if (work.shown.diagnostics) all.push_back({"Diagnostics", culling_tab});
  if (changes) all.insert(all.begin(), {"Compare", compare_tab});
  const Tab& front = tab_rows(work, all);
  ImGui::PushID(front.name);
  front.draw(work);
  ImGui::PopID();
}

}  // namespace

Margins margins(const Shown& shown) {
  const float bar = bar_height();
  return {int(panel_width(shown.tree_width, kTreeWidth, kTreeShare)),
          int(panel_width(shown.side_width, kSideWidth, kSideShare)), int(bar + toolbar_height()), int(bar)};
}

void splitters(Shown& shown) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const Margins m = margins(shown);
  const float height = size.y - float(m.top + m.bottom), font = ImGui::GetFontSize();
  const float tree = drag_edge("##tree-edge", float(m.left), float(m.top), height, true),
              side = drag_edge("##side-edge", size.x - float(m.right), float(m.top), height, false);
  if (tree != 0.0f) shown.tree_width = std::max(kLeastWidth, (float(m.left) + tree) / font);
  if (side != 0.0f) shown.side_width = std::max(kLeastWidth, (float(m.right) - side) / font);
}

void side_panel(Workspace& work) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const Margins m = margins(work.shown);
  begin_fixed("##side", size.x - float(m.right), float(m.top), float(m.right), size.y - float(m.top + m.bottom),
              ImGuiWindowFlags_NoTitleBar);
  if (work.session) tabs(work);
  ImGui::End();
}

void taken_tip(const core::Scene& scene, const Taken& taken) {
  const std::string name = taken.node.valid() ? std::string(scene.name(taken.node)) : item_name(scene, taken.item);
  const std::string what = taken.items.size() == 1 ? std::string(core::name_of(scene.kind(taken.item)))
                                                   : grouped(std::int64_t(taken.items.size())) + " items";
  ImGui::SetTooltip("%s", (name.empty() || name == what ? what : name + "\n" + what).c_str());
}

}  // namespace sightline::apps
