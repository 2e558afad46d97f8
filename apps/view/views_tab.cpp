#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/small_image.h"
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
void view_row(Workspace& work, std::size_t index, float height) {
  const Viewpoint& view = work.views.all()[index];
  const ImVec2 at = ImGui::GetCursorPos(), corner = ImGui::GetCursorScreenPos();
  const float line = ImGui::GetTextLineHeight(), wide = 1.4f * height, pad = 0.1f * line;
  const std::string number = std::to_string(index + 1);
  ImGui::PushID(int(index));
  if (ImGui::Selectable("##view", int(index) == work.views.current_index(), 0, {0.0f, height}))
    run(work, "view-show", number);
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("%s%s%s", view.name.c_str(), view.comment.empty() ? "" : "\n", view.comment.c_str());
  // The snapshot of a view that is updated lies elsewhere in memory.
  const std::string key = view.guid + " " + std::to_string(reinterpret_cast<std::uintptr_t>(view.snapshot.data()));
  framed_image(work.textures.get(work.window.context(), key, [&] { return small_image(view); }),
               {corner.x + pad, corner.y + pad}, {wide - 2.0f * pad, height - 2.0f * pad});
  const float left = at.x + wide + 0.4f * line;
  ImGui::SetCursorPos({left, at.y + 0.5f * height - line});
  ImGui::TextUnformatted((number + "  " + view.name).c_str());
  ImGui::SetCursorPos({left, at.y + 0.5f * height});
  ImGui::TextDisabled("%s", view.comment.substr(0, view.comment.find('\n')).c_str());
  ImGui::SetCursorPos({at.x, at.y + height + ImGui::GetStyle().ItemSpacing.y});
  ImGui::PopID();
}

// The values that BCF's own lists of extensions begin with; others can be typed.
constexpr const char* kStatuses[] = {"Open", "In Progress", "Resolved", "Closed"};
constexpr const char* kTypes[] = {"Issue", "Request", "Clash", "Remark", "Fault", "Solution"};

/// A text, and a list of usual ones.
void topic_field(const char* name, std::span<const char* const> usual, std::string& text) {
  const float font = ImGui::GetFontSize();
  ImGui::PushID(name);
  ImGui::SetNextItemWidth(6.0f * font);
  ImGui::InputTextWithHint("##text", name, &text);
  ImGui::SameLine(0.0f, 0.0f);
  if (ImGui::BeginCombo("##usual", nullptr, ImGuiComboFlags_NoPreview)) {
    for (const char* one : usual)
      if (ImGui::Selectable(one, text == one)) text = one;
    ImGui::EndCombo();
  }
  ImGui::PopID();
}

/// What can be done with the current view, below the list.
void current_view(Workspace& work, Viewpoint& view) {
  ImGui::Separator();
  ImGui::SetNextItemWidth(-1.0f);
  ImGui::InputText("##name", &view.name);
  topic_field("status", kStatuses, view.status);
  ImGui::SameLine();
  topic_field("type", kTypes, view.type);
  ImGui::InputTextMultiline("##comment", &view.comment, {-1.0f, 5.0f * ImGui::GetTextLineHeight()});
  if (ImGui::Button("Update")) run(work, "view-update");
  ImGui::SameLine();
  if (ImGui::Button("Up")) work.views.move_current(-1);
  ImGui::SameLine();
  if (ImGui::Button("Down")) work.views.move_current(1);
  ImGui::SameLine();
  if (ImGui::Button("Delete")) run(work, "view-delete");
}

}  // namespace

void views_tab(Workspace& work) {
  ViewList& views = work.views;
  if (ImGui::Button("Add what is seen now")) run(work, "view-add");
  const float line = ImGui::GetTextLineHeightWithSpacing(), below = 14.5f * line, row = 3.6f * line;
  const float high = std::max(row, ImGui::GetContentRegionAvail().y - below);
  if (ImGui::BeginChild("##list", {0.0f, high}, true)) {
    ImGuiListClipper clipper;
    clipper.Begin(int(views.size()), row + ImGui::GetStyle().ItemSpacing.y);
    while (clipper.Step())
      for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) view_row(work, std::size_t(i), row);
    clipper.End();
  }
  ImGui::EndChild();
  if (Viewpoint* view = views.current()) current_view(work, *view);
  ImGui::Separator();
  if (ImGui::Button("Save all…")) run(work, "views-save");
  ImGui::SameLine();
  if (ImGui::Button("Load…")) run(work, "views-load");
}

}  // namespace sightline::apps
