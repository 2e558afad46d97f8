#include <algorithm>
#include <filesystem>
#include <map>
#include <string>

#include "sightline/apps/common/item_facts.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/view/model_facts.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

constexpr std::size_t kMostWarnings = 100;

/// Names and attributes of a node and of those above.
void node_properties(const core::Scene& scene, core::NodeId lowest) {
  for (core::NodeId node = lowest; node.valid(); node = scene.parent(node)) {
    const std::string name(scene.name(node));
    if (name.empty() && scene.attributes(node).empty()) continue;
    ImGui::PushID(int(node.index));
    if (ImGui::CollapsingHeader(name.empty() ? "(no name)" : name.c_str(), ImGuiTreeNodeFlags_DefaultOpen) &&
        !scene.attributes(node).empty() && begin_rows("attributes")) {
      for (const auto& [key, value] : scene.attributes(node)) row(std::string(key).c_str(), std::string(value));
      ImGui::EndTable();
    }
    ImGui::PopID();
  }
}

void item_properties(const core::Scene& scene, core::ItemId item, const LengthFormat& lengths) {
  if (begin_rows("item")) {
    for (const Fact& fact : item_facts(scene, item, lengths)) row(fact.name.c_str(), fact.value);
    ImGui::EndTable();
  }
  node_properties(scene, scene.node_of(item));
}

/// What has become of an item since the older revision, and what differs in its facts.
void item_changes(const ChangeList& changes, const core::Scene& scene, core::ItemId item, const LengthFormat& lengths) {
  const compare::Change* change = changes.of(item);
  if (!change) return;
  const std::string older = std::filesystem::path(changes.file()).filename().string();
  if (!ImGui::CollapsingHeader(("Since " + older).c_str(), ImGuiTreeNodeFlags_DefaultOpen)) return;
  ImGui::TextWrapped("%s", describe(*change, lengths).c_str());
  const auto or_none = [](const std::string& value) { return value.empty() ? "none" : value; };
  if (!begin_rows("changes")) return;
  for (const FactChange& fact : changes.differing_facts(scene, item))
    row(fact.name.c_str(), or_none(fact.after) + "\nwas " + or_none(fact.before));
  ImGui::EndTable();
}

void selection_properties(const core::Scene& scene, const Document& document, const LengthFormat& lengths) {
  const auto selection = document.selection();
  std::map<std::string, std::int64_t> kinds;
  for (const core::ItemId item : selection) ++kinds[std::string(core::name_of(scene.kind(item)))];
  if (!begin_rows("kinds")) return;
  for (const auto& [kind, count] : kinds) row(kind.c_str(), grouped(count));
  if (const core::AabbD bounds = document.bounds(selection); !bounds.empty()) {
    row("size", lengths.text(bounds.size()));
    row("from", lengths.text(bounds.min));
    row("to", lengths.text(bounds.max));
  }
  ImGui::EndTable();
  if (const core::NodeId part = document.selected_part(); part.valid()) node_properties(scene, part);
}

/// What is odd, and what readers noticed.
void model_warnings(Workspace& work) {
  Session& session = *work.session;
  const std::vector<Finding>& found = session.findings();
  const auto& warnings = session.model().report.warnings;
  if (found.empty() && warnings.empty()) return;
  const std::size_t count = found.size() + warnings.size();
  const std::string title = grouped(std::int64_t(count)) + (count == 1 ? " warning" : " warnings") + "###warnings";
  if (!ImGui::CollapsingHeader(title.c_str(), ImGuiTreeNodeFlags_DefaultOpen)) return;
  for (std::size_t i = 0; i < found.size(); ++i) {
    ImGui::PushID(int(i));
    wrapped_text(found[i].words);
    if (ImGui::SmallButton("Select them")) {
      run(work, "select-finding", std::to_string(i + 1));
      run(work, "focus");
    }
    ImGui::PopID();
  }
  for (std::size_t i = 0; i < std::min(warnings.size(), kMostWarnings); ++i) {
    const std::string file = std::filesystem::path(warnings[i].file).filename().string();
    wrapped_text((file.empty() ? "" : file + ": ") + warnings[i].message);
  }
  if (warnings.size() > kMostWarnings) ImGui::TextDisabled("and more; sightline-info lists all");
}

void model_properties(Workspace& work) {
  Session& session = *work.session;
  if (begin_rows("model")) {
    for (const Fact& fact :
         model_facts(work.files(), work.file_states, session.scene(), session.bounds().bounds, work.lengths()))
      row(fact.name.c_str(), fact.value);
    ImGui::EndTable();
  }
  if (const auto& recognition = session.model().report.recognition; recognition.meshes > 0)
    wrapped_text(recognition_words(recognition) + ".");
  model_warnings(work);
  ImGui::Separator();
  wrapped_text("Nothing is selected. Click on something, or press F1 for keys and mouse.");
}

}  // namespace

void properties_tab(Workspace& work) {
  Session& session = *work.session;
  const auto selection = session.document.selection();
  if (selection.empty()) {
    return model_properties(work);
  }
  ImGui::Text("%s item%s selected", grouped(std::int64_t(selection.size())).c_str(), selection.size() == 1 ? "" : "s");
  const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
  for (const char* name : {"hide", "isolate", "ghost-others", "focus", "properties-copy", "properties-save"})
    command_button(work, name, right);
  ImGui::NewLine();
  ImGui::Separator();
  if (selection.size() == 1) {
    if (session.changes()) item_changes(*session.changes(), session.scene(), selection[0], work.lengths());
    item_properties(session.scene(), selection[0], work.lengths());
  } else {
    selection_properties(session.scene(), session.document, work.lengths());
  }
}

}  // namespace sightline::apps
