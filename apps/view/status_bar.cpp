// The line at the bottom: what has happened, and at its right end what the cursor is over, what is selected, what the
// mouse does, and the units.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <imgui.h>

#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

constexpr float kNameLines = 14.0f, kFieldGapLines = 1.5f, kBarLines = 20.0f;  // in lines of text

struct Field {
  std::string text, tip;
};

Field cursor_field(Workspace& work) {
  auto at = work.gestures.cursor_point();
  if (!at) return {};
  const LengthFormat lengths = work.lengths();
  *at -= work.session->offset();
  std::string text;
  for (int axis = 0; axis < 3; ++axis)
    text += std::string(axis > 0 ? "  " : "") + "XYZ"[axis] + " " + lengths.number((*at)[axis]);
  return {text, "what the cursor is over, in " + std::string(lengths.unit())};
}

Field selection_field(const Session& session) {
  const Document& document = session.document;
  const auto selection = document.selection();
  const std::string hidden =
      document.hidden() == 0 ? "" : grouped(std::int64_t(document.hidden())) + " hidden; U shows all";
  if (selection.empty()) return {hidden, ""};
  std::string tip = selection.size() == 1 ? session.scene().path(session.scene().node_of(selection[0])) : "";
  const std::string text = selection.size() == 1
                               ? shortened(item_name(session.scene(), selection[0]), kNameLines * ImGui::GetFontSize())
                               : grouped(std::int64_t(selection.size())) + " selected";
  return {hidden.empty() ? text : text + ", " + grouped(std::int64_t(document.hidden())) + " hidden", std::move(tip)};
}

Field mode_field(Workspace& work) {
  constexpr const char* kTools[] = {"Select", "Measure", "Pick a face", "Mark up"};
  std::string text = kTools[int(work.shown.tool)];
  if (work.gestures.walking()) text += ", walk 1.5 m/s";
  static_assert(Walker::kSpeed == 1.5);
  if (work.recorder.has_value()) text += ", recording";
  if (work.player.playing()) text += ", playing";
  if (work.session->slider.at()) text += ", slider";
  if (work.session->image.frozen()) text += ", culling camera frozen";
  return {text, "what clicks do"};
}

/// Returns where the fields begin.
float fields(const std::vector<Field>& all) {
  const float gap = kFieldGapLines * ImGui::GetFontSize();
  float x = ImGui::GetWindowWidth() - ImGui::GetStyle().WindowPadding.x;
  for (auto field = all.rbegin(); field != all.rend(); ++field) {
    if (field->text.empty()) continue;
    x -= ImGui::CalcTextSize(field->text.c_str()).x;
    ImGui::SameLine(x);
    ImGui::TextUnformatted(field->text.c_str());
    if (ImGui::IsItemHovered() && !field->tip.empty()) ImGui::SetTooltip("%s", field->tip.c_str());
    x -= gap;
  }
  return x;
}

/// What could not be opened, without its damage. Returns the room that is left.
float offer_of_damaged(Workspace& work, float wide) {
  if (!work.offers_damaged()) return wide;
  const ImVec2 padding = ImGui::GetStyle().FramePadding;
  const float begin = ImGui::GetCursorPosX();
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {padding.x, 0.0f});
  const Command& command = *find_command("open-lenient");
  if (ImGui::Button(command.title)) run(work, command);
  ImGui::PopStyleVar();
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("Leaves out what is damaged, and lists that in the tab Item");
  ImGui::SameLine();
  return wide - (ImGui::GetCursorPosX() - begin);
}

void message(Workspace& work, float width) {
  const float wide = offer_of_damaged(work, width);
  const std::string& text = work.messages.text();
  const bool fits = ImGui::CalcTextSize(text.c_str()).x <= wide;
  if (work.messages.is_error()) ImGui::PushStyleColor(ImGuiCol_Text, kErrorColour);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::PushClipRect(at, {at.x + wide, at.y + ImGui::GetFrameHeight()}, true);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopClipRect();
  if (work.messages.is_error()) ImGui::PopStyleColor();
  if (!fits && ImGui::IsItemHovered() && ImGui::GetMousePos().x < at.x + wide) ImGui::SetTooltip("%s", text.c_str());
}

/// What is written in the background, in place of the message, with a button that cancels.
void writing(ModelExport& running, float wide) {
  const ImVec2 padding = ImGui::GetStyle().FramePadding;
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {padding.x, 0.0f});
  ImGui::BeginDisabled(running.cancelled());
  if (ImGui::Button("Cancel")) running.cancel();
  ImGui::EndDisabled();
  ImGui::SameLine();
  const std::string words = std::to_string(int(100.0 * running.progress())) + " % of " +
                            std::filesystem::path(running.file()).filename().string();
  const float room = std::max(1.0f, wide - ImGui::GetCursorPosX());
  ImGui::ProgressBar(float(running.progress()), {std::min(room, kBarLines * ImGui::GetFontSize()), 0.0f},
                     shortened(words, room).c_str());
  ImGui::PopStyleVar();
}

}  // namespace

void status_bar(Workspace& work) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float bar = ImGui::GetFrameHeight(), padding = ImGui::GetStyle().WindowPadding.x;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {padding, ImGui::GetStyle().FramePadding.y});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1.0f, 1.0f});
  begin_fixed("##status", 0.0f, size.y - bar, size.x, bar, ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoScrollbar);
  const ImVec2 begin = ImGui::GetCursorPos();
  float wide = size.x - 2.0f * padding;
  if (work.session) {
    ImGui::Dummy({0.0f, 0.0f});
    wide = fields({cursor_field(work),
                   selection_field(*work.session),
                   mode_field(work),
                   {work.lengths().unit(), "units: View, Units"}}) -
           padding;
  }
  ImGui::SetCursorPos(begin);
  if (work.exports.model())
    writing(*work.exports.model(), wide);
  else
    message(work, std::max(0.0f, wide));
  ImGui::End();
  ImGui::PopStyleVar(2);
}

}  // namespace sightline::apps
