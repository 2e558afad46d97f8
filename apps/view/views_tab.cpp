#include <cstdint>
#include <optional>
#include <string>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/small_image.h"
#include "sightline/apps/view/views.h"
#include "sightline/apps/view/widgets.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {
namespace {

/// The image of a snapshot; none for bytes that are no image.
std::optional<image::Image> small_image(const Viewpoint& view) {
  constexpr int kWidth = 320;
  const auto image = image::decode_png(view.snapshot);
  return image ? std::optional(shrunk(*image, kWidth)) : std::nullopt;
}

/// Image, number and name, and the beginning of the comment.
void view_row(Viewer& viewer, std::size_t index, float height) {
  const Viewpoint& view = viewer.views().all()[index];
  const ImVec2 at = ImGui::GetCursorPos(), corner = ImGui::GetCursorScreenPos();
  const float line = ImGui::GetTextLineHeight(), wide = 1.4f * height, pad = 0.1f * line;
  const std::string number = std::to_string(index + 1);
  ImGui::PushID(int(index));
  if (ImGui::Selectable("##view", int(index) == viewer.views().current_index(), 0, {0.0f, height}))
    viewer.tell_outcome(show_view(viewer, number));
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("%s%s%s", view.name.c_str(), view.comment.empty() ? "" : "\n", view.comment.c_str());
  // The snapshot of a view that is updated lies elsewhere in memory.
  const std::string key = view.guid + " " + std::to_string(reinterpret_cast<std::uintptr_t>(view.snapshot.data()));
  framed_image(viewer.textures().get(viewer.context(), key, [&] { return small_image(view); }),
               {corner.x + pad, corner.y + pad}, {wide - 2.0f * pad, height - 2.0f * pad});
  const float left = at.x + wide + 0.4f * line;
  ImGui::SetCursorPos({left, at.y + 0.5f * height - line});
  ImGui::TextUnformatted((number + "  " + view.name).c_str());
  ImGui::SetCursorPos({left, at.y + 0.5f * height});
  ImGui::TextDisabled("%s", view.comment.substr(0, view.comment.find('\n')).c_str());
  ImGui::SetCursorPos({at.x, at.y + height + ImGui::GetStyle().ItemSpacing.y});
  ImGui::PopID();
}

/// What can be done with the current view, below the list.
void current_view(Viewer& viewer, Viewpoint& view) {
  ImGui::Separator();
  ImGui::SetNextItemWidth(-1.0f);
  ImGui::InputText("##name", &view.name);
  ImGui::InputTextMultiline("##comment", &view.comment, {-1.0f, 5.0f * ImGui::GetTextLineHeight()});
  if (ImGui::Button("Update")) viewer.tell_outcome(update_view(viewer, ""));
  ImGui::SameLine();
  if (ImGui::Button("Up")) viewer.views().move_current(-1);
  ImGui::SameLine();
  if (ImGui::Button("Down")) viewer.views().move_current(1);
  ImGui::SameLine();
  if (ImGui::Button("Delete")) viewer.tell_outcome(delete_view(viewer, ""));
}

}  // namespace

void views_tab(Viewer& viewer) {
  ViewList& views = viewer.views();
  if (ImGui::Button("Add what is seen now")) viewer.tell_outcome(add_view(viewer, ""));
  const float line = ImGui::GetTextLineHeightWithSpacing(), below = 13.0f * line, row = 3.6f * line;
  const float high = std::max(row, ImGui::GetContentRegionAvail().y - below);
  if (ImGui::BeginChild("##list", {0.0f, high}, true)) {
    ImGuiListClipper clipper;
    clipper.Begin(int(views.size()), row + ImGui::GetStyle().ItemSpacing.y);
    while (clipper.Step())
      for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) view_row(viewer, std::size_t(i), row);
    clipper.End();
  }
  ImGui::EndChild();
  if (Viewpoint* view = views.current()) current_view(viewer, *view);
  ImGui::Separator();
  if (ImGui::Button("Save all…")) viewer.tell_outcome(save_views(viewer, ""));
  ImGui::SameLine();
  if (ImGui::Button("Load…")) viewer.tell_outcome(load_views(viewer, ""));
}

}  // namespace sightline::apps
