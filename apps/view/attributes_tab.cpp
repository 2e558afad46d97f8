#include <string>
#include <utility>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

constexpr float kKeyLines = 9.0f;  // height of the list of keys, in lines of text

/// The text, or where there is none a word that says so.
std::string shown(const std::string& value) {
  return value.empty() ? "(empty)" : value;
}

/// A table with a wide first column and counts; ImGui::EndTable() ends it where this is true.
bool begin_counts(const char* name, const std::vector<const char*>& heads, float high) {
  if (!ImGui::BeginTable(name, int(heads.size()), ImGuiTableFlags_RowBg | ImGuiTableFlags_ScrollY, {0.0f, high}))
    return false;
  ImGui::TableSetupScrollFreeze(0, 1);
  for (const char* head : heads)
    ImGui::TableSetupColumn(
        head, head == heads.front() ? ImGuiTableColumnFlags_WidthStretch : ImGuiTableColumnFlags_WidthFixed);
  ImGui::TableHeadersRow();
  return true;
}

/// A row that can be clicked on: a text, and what follows in the next columns.
bool count_row(const std::string& text, bool selected, const std::vector<std::string>& counts) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  const bool clicked = ImGui::Selectable("##row", selected, ImGuiSelectableFlags_SpanAllColumns);
  if (ImGui::IsItemHovered() && !NarrowerThan{ImGui::GetContentRegionAvail().x}(text))
    ImGui::SetTooltip("%s", text.c_str());
  ImGui::SameLine(0.0f, 0.0f);
  ImGui::TextUnformatted(shortened(text, ImGui::GetContentRegionAvail().x).c_str());
  for (const std::string& count : counts) {
    ImGui::TableNextColumn();
    selected ? ImGui::TextUnformatted(count.c_str()) : ImGui::TextDisabled("%s", count.c_str());
  }
  return clicked;
}

void keys(AttributeList& attributes) {
  if (!begin_counts("##keys", {"attribute", "values", "items"}, kKeyLines * ImGui::GetTextLineHeightWithSpacing()))
    return;
  for (const query::Key& key : attributes.keys()) {
    ImGui::PushID(key.name.c_str());
    const std::string values = key.values > 0 ? grouped(key.values) : "";
    if (count_row(key.name, key.name == attributes.chosen(), {values, grouped(key.items)})) attributes.choose(key.name);
    ImGui::PopID();
  }
  ImGui::EndTable();
}

/// Looks for a condition and selects what it is true of; with Ctrl, in what was found before.
void search(Workspace& work, const std::string& condition) {
  const std::string& before = work.session->tree.query().text;
  const bool also = ImGui::GetIO().KeyCtrl && !before.empty();
  run(work, "find", also ? before + " & " + condition : condition);
  if (work.session->tree.named()) run(work, "select-found");
}

/// Two numbers, and a button that looks for what lies between.
void range(Workspace& work, AttributeList& attributes) {
  static std::string from, to;
  const float field = 5.0f * ImGui::GetFontSize();
  ImGui::SetNextItemWidth(field);
  ImGui::InputTextWithHint("##from", "from", &from);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(field);
  ImGui::InputTextWithHint("##to", "to", &to);
  ImGui::SameLine();
  if (!ImGui::Button("Find")) return;
  const auto condition = condition_of_range(attributes.chosen(), from, to);
  if (condition)
    search(work, *condition);
  else
    work.messages.tell(condition.error().message, true);
}

void values(Workspace& work, AttributeList& attributes) {
  const query::Values& values = attributes.values();
  if (!begin_counts("##values", {attributes.chosen().c_str(), "items"}, ImGui::GetContentRegionAvail().y)) return;
  ImGuiListClipper clipper;
  clipper.Begin(int(values.all.size()));
  while (clipper.Step())
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
      const query::Values::Value& value = values.all[std::size_t(i)];
      ImGui::PushID(i);
      if (count_row(shown(value.text), false, {grouped(value.items)}))
        search(work, condition_of(attributes.chosen(), value.text));
      ImGui::PopID();
    }
  clipper.End();
  ImGui::EndTable();
}

}  // namespace

void attributes_tab(Workspace& work) {
  AttributeList& attributes = work.session->attributes;
  keys(attributes);
  if (attributes.chosen().empty()) return wrapped_text("Click on an attribute: its values are listed here.");
  bool coloured = work.session->colouring.key == attributes.chosen();
  if (ImGui::Checkbox("Colour by this", &coloured)) run(work, "colour-by", coloured ? attributes.chosen() : "");
  if (attributes.has_numbers()) range(work, attributes);
  ImGui::TextDisabled("A click selects; with Ctrl, of what is found.");
  values(work, attributes);
}

}  // namespace sightline::apps
