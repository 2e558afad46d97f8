#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {

void measure_tab(Viewer& viewer) {
  Session& session = *viewer.session();
  const Command& measure = *find_command("measure");
  bool on = viewer.shown.tool == Tool::kMeasure;
  if (ImGui::Checkbox(measure.title, &on)) run(viewer, measure);
  ImGui::TextWrapped("Click on two things. Marks snap to corners, edges, centres and axes.");
  if (ImGui::Button("Distance of two selected items")) run(viewer, *find_command("measure-selected"));
  ImGui::SameLine();
  if (ImGui::Button("Clear")) session.measuring().clear();
  if (!begin_rows("measured")) return;
  for (const auto& [what, value] : session.measuring().rows(viewer.lengths())) row(what.c_str(), value);
  ImGui::EndTable();
}

}  // namespace sightline::apps
