#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {

void sections_tab(Viewer& viewer) {
  Session& session = *viewer.session();
  for (const char* name : {"section-box", "section-clear"})
    if (ImGui::Button(find_command(name)->title)) run(viewer, *find_command(name));
  ImGui::TextWrapped("X cuts at the face under the cursor. Drag a number to move its section.");
  const core::AabbD& bounds = session.bounds().bounds;
  const double size = bounds.empty() ? 1.0 : glm::length(bounds.size());
  std::vector<Sections::Section>& all = session.sections().all();
  for (std::size_t i = 0; i < all.size(); ++i) {
    ImGui::PushID(int(i));
    ImGui::Checkbox("##on", &all[i].on);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(6.0f * ImGui::GetFontSize());
    ImGui::DragScalar("##offset", ImGuiDataType_Double, &all[i].offset, float(1e-3 * size), nullptr, nullptr, "%.3f m");
    ImGui::SameLine();
    if (ImGui::SmallButton("Flip")) Sections::flip(all[i]);
    ImGui::SameLine();
    const bool remove = ImGui::SmallButton("Remove");
    ImGui::Text("out of %s", vector_text(all[i].normal).c_str());
    ImGui::PopID();
    if (remove) session.sections().remove(i--);
  }
}

}  // namespace sightline::apps
