#include <algorithm>
#include <string>

#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

/// A number that is typed or dragged, in the model's units. `metres` is left alone unless it is changed.
void length_field(const char* name, double& metres, const LengthFormat& lengths, double step, float wide) {
  const double per_metre = lengths.per_metre();
  double value = metres * per_metre;
  const std::string format = "%." + std::to_string(lengths.decimals) + "f " + lengths.unit();
  ImGui::SetNextItemWidth(wide);
  if (ImGui::DragScalar(name, ImGuiDataType_Double, &value, float(step * per_metre), nullptr, nullptr, format.c_str()))
    metres = value / per_metre;
}

/// Where the section is: on its axis, or how far it was moved along its normal.
void place_field(Sections::Section& section, const core::dvec3& origin, const LengthFormat& lengths, double step,
                 float wide) {
  const auto axis = section_axis(section);
  if (!axis) return length_field("##moved", section.offset, lengths, step, wide);
  const double before = (section.place() - origin)[*axis];
  double place = before;
  length_field("##place", place, lengths, step, wide);
  section.offset += (place - before) * (section.normal[*axis] > 0.0 ? 1.0 : -1.0);
}

/// All six sides as one.
void box_entry(Workspace& work, Sections& sections, const std::array<std::size_t, 6>& sides, double step) {
  std::vector<Sections::Section>& all = sections.all();
  const LengthFormat lengths = work.lengths();
  const std::array<core::dvec3, 8> corners = box_corners(sections, sides);
  ImGui::PushID("box");
  bool on = std::all_of(sides.begin(), sides.end(), [&](std::size_t side) { return all[side].on; });
  if (ImGui::Checkbox("##on", &on))
    for (const std::size_t side : sides) all[side].on = on;
  ImGui::SameLine();
  std::string size;
  for (const std::size_t corner : {1u, 2u, 4u})
    size += (size.empty() ? "" : " × ") + lengths.number(glm::length(corners[corner] - corners[0]));
  wrapped_text("box, " + size + " " + lengths.unit());
  for (std::size_t pair = 0; pair < 3; ++pair) {
    ImGui::PushID(int(pair));
    const auto axis = section_axis(all[sides[2 * pair]]);
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(axis ? std::string(1, "XYZ"[*axis]).c_str() : "");
    ImGui::SameLine();
    const float wide = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
    for (const std::size_t side : {sides[2 * pair + 1], sides[2 * pair]}) {
      if (side == sides[2 * pair]) ImGui::SameLine();
      ImGui::PushID(int(side));
      place_field(all[side], work.session->offset(), lengths, step, wide);
      ImGui::PopID();
    }
    ImGui::PopID();
  }
  const bool remove = ImGui::SmallButton("Remove the box");
  ImGui::PopID();
  if (!remove) return;
  std::array<std::size_t, 6> last_first = sides;
  std::sort(last_first.begin(), last_first.end(), std::greater<>());
  for (const std::size_t side : last_first) sections.remove(side);
}

/// Returns whether it is to be removed.
bool section_entry(Workspace& work, Sections& sections, std::size_t index, double step) {
  Sections::Section& section = sections.all()[index];
  const core::dvec3& origin = work.session->offset();
  const bool selected = sections.selected() == index;
  ImGui::PushID(int(index));
  ImGui::Checkbox("##on", &section.on);
  ImGui::SameLine();
  const std::string title =
      std::to_string(index + 1) + "  " + unbroken(section_words(section, origin, work.lengths())) + "###title";
  if (ImGui::Selectable(title.c_str(), selected))
    sections.select(selected ? std::nullopt : std::optional<std::size_t>(index));
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("what is kept; a click shows the handles that turn it");
  place_field(section, origin, work.lengths(), step,
              std::min(7.5f * ImGui::GetFontSize(), 0.5f * ImGui::GetContentRegionAvail().x));
  ImGui::SameLine();
  if (ImGui::SmallButton("Flip")) Sections::flip(section);
  ImGui::SameLine();
  const bool remove = ImGui::SmallButton("Remove");
  ImGui::PopID();
  return remove;
}

}  // namespace

void sections_tab(Workspace& work) {
  Session& session = *work.session;
  const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
  for (const char* name : {"section-face", "section-box", "section-z", "section-x", "section-y", "section-clear"})
    command_button(work, name, right);
  ImGui::NewLine();
  ImGui::TextWrapped("X cuts at the face under the cursor. Drag the arrows in the image, or a number here.");
  ImGui::Separator();
  const core::AabbD& bounds = session.bounds().bounds;
  const double step = 1e-3 * (bounds.empty() ? 1.0 : glm::length(bounds.size()));
  Sections& sections = session.sections;
  const auto box = sections.box();
  if (box) box_entry(work, sections, *box, step);
  const auto of_box = [&](std::size_t index) { return box && std::count(box->begin(), box->end(), index) > 0; };
  for (std::size_t i = 0; i < sections.all().size(); ++i)
    if (!of_box(i) && section_entry(work, sections, i, step)) return sections.remove(i);
}

}  // namespace sightline::apps
