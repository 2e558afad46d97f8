#include <optional>
#include <string>

#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

/// All measurements; a button removes one.
void measurement_list(Measuring& measuring, const LengthFormat& lengths) {
  if (!ImGui::BeginTable("##list", 3, ImGuiTableFlags_RowBg)) return;
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed);
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch);
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed);
  std::optional<std::size_t> removed;
  for (std::size_t i = 0; i < measuring.list().size(); ++i) {
    const Measurement& one = measuring.list()[i];
    ImGui::PushID(int(i));
    ImGui::TableNextColumn();
    ImGui::Text("%zu", i + 1);
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(unbroken(lengths.text(one.distance())).c_str());
    if (!one.words.empty() && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", one.words.c_str());
    ImGui::TableNextColumn();
    if (ImGui::SmallButton("×")) removed = i;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Remove from the list");
    ImGui::PopID();
  }
  ImGui::EndTable();
  if (removed) measuring.remove(*removed);
}

}  // namespace

void measure_tab(Workspace& work) {
  Measuring& measuring = work.session->measuring;
  const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
  for (const char* name : {"measure", "measure-angle", "measure-selected", "weigh", "measure-copy", "measure-clear"})
    command_button(work, name, right);
  ImGui::NewLine();
  if (measuring.list().empty() && measuring.marks().empty())
    wrapped_text("Click on two things. Marks snap to corners, edges, centres and axes.");
  ImGui::SetNextItemWidth(5.0f * ImGui::GetFontSize());
  double density = work.shown.density;
  if (ImGui::InputDouble("kg/m³", &density, 0.0, 0.0, "%.6g") && density > 0.0 && density <= Settings::kLargestDensity)
    work.shown.density = density;
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("The density of what is weighed; steel has 7,850");
  measurement_list(measuring, work.lengths());
  const auto rows = measuring.rows(work.lengths());
  if (rows.empty()) return;
  ImGui::Separator();
  if (!begin_rows("measured")) return;
  for (const auto& [what, value] : rows) row(what.c_str(), value);
  ImGui::EndTable();
}

}  // namespace sightline::apps
