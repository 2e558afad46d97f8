#include <optional>
#include <string>
#include <utility>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

using Kind = Markup::Kind;

/// What is drawn next. A choice takes the tool.
void kinds(Workspace& work) {
  constexpr std::pair<Kind, const char*> kAll[] = {
      {Kind::kArrow, "Arrow"}, {Kind::kCloud, "Cloud"}, {Kind::kText, "Text"}};
  Marking& marking = work.session->marking;
  for (const auto& [kind, name] : kAll) {
    if (kind != Kind::kArrow) ImGui::SameLine();
    if (!ImGui::RadioButton(name, work.shown.tool == Tool::kMark && marking.kind == kind)) continue;
    marking.kind = kind;
    work.shown.tool = Tool::kMark;
  }
}

/// All mark-ups; a button removes one.
void markup_list(Marking& marking) {
  if (!ImGui::BeginTable("##list", 3, ImGuiTableFlags_RowBg)) return;
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed);
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch);
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed);
  std::optional<std::size_t> removed;
  for (std::size_t i = 0; i < marking.list().size(); ++i) {
    const Markup& one = marking.list()[i];
    ImGui::PushID(int(i));
    ImGui::TableNextColumn();
    ImGui::Text("%zu", i + 1);
    ImGui::TableNextColumn();
    ImGui::TextUnformatted((std::string(name_of(one.kind)) + (one.words.empty() ? "" : ": " + one.words)).c_str());
    ImGui::TableNextColumn();
    if (ImGui::SmallButton("×")) removed = i;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Remove");
    ImGui::PopID();
  }
  ImGui::EndTable();
  if (removed) marking.remove(*removed);
}

}  // namespace

void mark_tab(Workspace& work) {
  Marking& marking = work.session->marking;
  kinds(work);
  ImGui::SetNextItemWidth(-1.0f);
  if (marking.asks_for_words()) ImGui::SetKeyboardFocusHere();
  ImGui::InputTextWithHint("##words", "words", &marking.words());
  if (ImGui::IsItemDeactivated()) marking.end_writing();
  const bool text = marking.kind == Kind::kText;
  wrapped_text(text                           ? "A click says where; then type the words."
               : marking.kind == Kind::kCloud ? "A drag draws a cloud around something; words may follow."
                                              : "A drag draws an arrow, from its tip; words may follow.");
  markup_list(marking);
  const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
  command_button(work, "marks-clear", right);
  command_button(work, "view-add", right);
  ImGui::NewLine();
}

}  // namespace sightline::apps
