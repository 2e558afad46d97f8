#include <string>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/views.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

/// What can be done with the current view, below the list.
void current_view(Viewer& viewer, Viewpoint& view) {
  ImGui::Separator();
  ImGui::SetNextItemWidth(-1.0f);
  ImGui::InputText("##name", &view.name);
  ImGui::InputTextMultiline("##comment", &view.comment, {-1.0f, 5.0f * ImGui::GetTextLineHeight()});
  if (ImGui::Button("Update")) viewer.tell_failure(update_view(viewer, ""));
  ImGui::SameLine();
  if (ImGui::Button("Up")) viewer.views().move_current(-1);
  ImGui::SameLine();
  if (ImGui::Button("Down")) viewer.views().move_current(1);
  ImGui::SameLine();
  if (ImGui::Button("Delete")) viewer.tell_failure(delete_view(viewer, ""));
}

}  // namespace

void views_tab(Viewer& viewer) {
  ViewList& views = viewer.views();
  if (ImGui::Button("Add what is seen now")) viewer.tell_failure(add_view(viewer, ""));
  const float line = ImGui::GetTextLineHeightWithSpacing(), below = 16.0f * line;
  const float high = std::max(4.0f * line, ImGui::GetContentRegionAvail().y - below);
  if (ImGui::BeginChild("##list", {0.0f, high}, true)) {
    for (std::size_t i = 0; i < views.size(); ++i) {
      ImGui::PushID(int(i));
      const std::string label = std::to_string(i + 1) + "  " + views.all()[i].name;
      if (ImGui::Selectable(label.c_str(), int(i) == views.current_index()))
        viewer.tell_failure(show_view(viewer, std::to_string(i + 1)));
      if (ImGui::IsItemHovered() && !views.all()[i].comment.empty())
        ImGui::SetTooltip("%s", views.all()[i].comment.c_str());
      ImGui::PopID();
    }
  }
  ImGui::EndChild();
  if (Viewpoint* view = views.current()) current_view(viewer, *view);
  ImGui::Separator();
  if (ImGui::Button("Save all…")) viewer.tell_failure(save_views(viewer, ""));
  ImGui::SameLine();
  if (ImGui::Button("Load…")) viewer.tell_failure(load_views(viewer, ""));
}

}  // namespace sightline::apps
