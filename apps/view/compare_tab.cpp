#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>

#include <imgui.h>

#include "sightline/apps/common/change_colours.h"
#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

using compare::State;

/// A square in the colour of a state, as high as a line; faint states have a frame alone.
void swatch(State state) {
  const float side = ImGui::GetTextLineHeight();
  const ImVec2 at = ImGui::GetCursorScreenPos(), end(at.x + side, at.y + side);
  if (const auto colour = change_colour(state))
    ImGui::GetWindowDrawList()->AddRectFilled(at, end, ImGui::GetColorU32({colour->r, colour->g, colour->b, 1.0f}));
  else
    ImGui::GetWindowDrawList()->AddRect(at, end, ImGui::GetColorU32(ImGuiCol_TextDisabled));
  ImGui::Dummy({side, side});
}

/// The states with their colours, counts and switches.
void legend(Workspace& work, const ChangeList& changes) {
  if (!ImGui::BeginTable("##legend", 3)) return;
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed);
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed);
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch);
  for (const State state : {State::kAdded, State::kRemoved, State::kMoved, State::kChanged, State::kUnchanged}) {
    const std::string name(compare::name_of(state));
    bool on = changes.shown(state);
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    if (ImGui::Checkbox(name.c_str(), &on)) run(work, "compare-toggle", name);
    ImGui::TableNextColumn();
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() + ImGui::GetStyle().FramePadding.y);
    swatch(state);
    ImGui::TableNextColumn();
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(grouped(std::int64_t(changes.found().count(state))).c_str());
  }
  ImGui::EndTable();
  const auto also = [](std::size_t count, const char* what) {
    if (count > 0) ImGui::TextWrapped("%s %s", grouped(std::int64_t(count)).c_str(), what);
  };
  also(changes.found().renamed, "of them renamed, or below other nodes");
  also(changes.found().nodes.size(), "nodes with other attributes");
}

/// Two lines: the name of the node, and what has become of the items below it.
void change_row(Workspace& work, ChangeList& changes, std::size_t row, float height) {
  const core::Scene& scene = work.session->scene();
  const std::string& what = changes.what(row, work.lengths());
  const ImVec2 at = ImGui::GetCursorPos();
  ImGui::PushID(int(row));
  if (ImGui::Selectable("##row", changes.current() == row, 0, {0.0f, height}))
    work.messages.tell_outcome(go_to_change(*work.session, row));
  if (ImGui::IsItemHovered()) {
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(25.0f * ImGui::GetFontSize());
    ImGui::Text("%s\n%s", scene.path(changes.node(scene, row)).c_str(), what.c_str());
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
  }
  ImGui::SetCursorPos(at);
  swatch(changes.state(row));
  const float indent = 1.4f * ImGui::GetTextLineHeight();
  ImGui::SetCursorPos({at.x + indent, at.y});
  const float room = ImGui::GetContentRegionAvail().x;
  ImGui::TextUnformatted(shortened(changes.name(row), room).c_str());
  ImGui::SetCursorPos({at.x + indent, at.y + ImGui::GetTextLineHeight()});
  ImGui::TextDisabled("%s", shortened(what, room).c_str());
  ImGui::SetCursorPos({at.x, at.y + height + ImGui::GetStyle().ItemSpacing.y});
  ImGui::PopID();
}

void list(Workspace& work, ChangeList& changes) {
  static std::optional<std::size_t> scrolled_to;
  const float height = 2.0f * ImGui::GetTextLineHeight(), pitch = height + ImGui::GetStyle().ItemSpacing.y;
  ImGui::BeginChild("##changes", {0.0f, 0.0f}, true);
  if (const auto current = changes.current(); current && current != std::exchange(scrolled_to, current)) {
    const float at = float(*current) * pitch, window = ImGui::GetWindowHeight();
    if (at < ImGui::GetScrollY() || at + pitch > ImGui::GetScrollY() + window)
      ImGui::SetScrollY(std::max(0.0f, at - 0.4f * window));
  }
  ImGuiListClipper clipper;
  clipper.Begin(int(changes.row_count()), pitch);
  while (clipper.Step())
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) change_row(work, changes, std::size_t(i), height);
  clipper.End();
  ImGui::EndChild();
}

}  // namespace

void compare_tab(Workspace& work) {
  ChangeList& changes = *work.session->changes();
  ImGui::TextWrapped("What is open is the newer revision. The older one: %s",
                     std::filesystem::path(changes.file()).filename().string().c_str());
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", changes.file().c_str());
  legend(work, changes);
  if (ImGui::Button("Previous")) run(work, "compare-previous");
  ImGui::SameLine();
  if (ImGui::Button("Next")) run(work, "compare-next");
  ImGui::SameLine();
  const std::string all = grouped(std::int64_t(changes.row_count()));
  if (changes.current())
    ImGui::Text("%s of %s", grouped(std::int64_t(*changes.current() + 1)).c_str(), all.c_str());
  else
    ImGui::TextUnformatted(all.c_str());
  const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
  for (const char* name : {"compare-slider", "compare-save"}) command_button(work, name, right);
  ImGui::NewLine();
  const bool ends = ImGui::Button("End the comparison");
  list(work, changes);
  if (ends) run(work, "compare-end");  // last: the list is gone then
}

}  // namespace sightline::apps
