#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {

void sections_tab(Viewer& viewer) {
  Session& session = *viewer.session();
  for (const char* name : {"section-box", "section-clear"})
    if (ImGui::Button(find_command(name)->title)) run(viewer, *find_command(name));
  ImGui::TextWrapped("X cuts at the face under the cursor. Drag the arrows in the image, or a number here.");
  const core::AabbD& bounds = session.bounds().bounds;
  const double size = bounds.empty() ? 1.0 : glm::length(bounds.size());
  Sections& sections = session.sections();
  std::vector<Sections::Section>& all = sections.all();
  for (std::size_t i = 0; i < all.size(); ++i) {
    ImGui::PushID(int(i));
    const bool selected = sections.selected() == i;
    ImGui::Checkbox("##on", &all[i].on);
    ImGui::SameLine();
    const std::string title = std::to_string(i + 1) + "   out of " + vector_text(all[i].normal);
    if (ImGui::Selectable(title.c_str(), selected))
      sections.select(selected ? std::nullopt : std::optional<std::size_t>(i));
    ImGui::SetNextItemWidth(6.0f * ImGui::GetFontSize());
    ImGui::DragScalar("##offset", ImGuiDataType_Double, &all[i].offset, float(1e-3 * size), nullptr, nullptr, "%.3f m");
    ImGui::SameLine();
    if (ImGui::SmallButton("Flip")) Sections::flip(all[i]);
    ImGui::SameLine();
    const bool remove = ImGui::SmallButton("Remove");
    ImGui::PopID();
    if (remove) sections.remove(i--);
  }
}

}  // namespace sightline::apps
