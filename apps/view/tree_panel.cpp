#include <algorithm>
#include <string>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

void tell_errors(Viewer& viewer, const core::Expected<void>& done) {
  if (!done) viewer.tell(done.error().message, true);
}

void select_below(Viewer& viewer, core::NodeId node) {
  Document& document = viewer.session()->document();
  const ImGuiIO& io = ImGui::GetIO();
  tell_errors(viewer, document.select(document.items_below(node), io.KeyCtrl    ? SelectMode::kToggle
                                                                  : io.KeyShift ? SelectMode::kAdd
                                                                                : SelectMode::kReplace));
}

void search_field(Viewer& viewer, ModelTree& tree) {
  NameQuery query = tree.query();
  const float button = ImGui::GetFrameHeight() + ImGui::GetStyle().ItemInnerSpacing.x + ImGui::CalcTextSize(".*").x;
  ImGui::SetNextItemWidth(-button - ImGui::GetStyle().ItemSpacing.x);
  if (viewer.shown.find) ImGui::SetKeyboardFocusHere();
  viewer.shown.find = false;
  bool changed = ImGui::InputTextWithHint("##find", "find: text, or attribute:text", &query.text);
  const bool entered = ImGui::IsItemDeactivatedAfterEdit() && ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Enter));
  ImGui::SameLine();
  changed |= ImGui::Checkbox(".*", &query.regular_expression);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("The text is a regular expression");
  if (changed) tree.find(query);
  if (query.text.empty()) return;
  if (!tree.error().empty()) {
    ImGui::TextWrapped("%s", tree.error().c_str());
    return;
  }
  ImGui::Text("%zu found, %.1f ms", tree.match_count(), tree.find_ms());
  ImGui::SameLine();
  if ((ImGui::SmallButton("Select") || entered) && !tree.matches().empty())
    tell_errors(viewer, viewer.select_nodes(tree.matches()));
}

void node_menu(Viewer& viewer, core::NodeId node, ModelTree& tree) {
  if (!ImGui::BeginPopupContextItem()) return;
  const std::vector<core::ItemId> items = viewer.session()->document().items_below(node);
  Document& document = viewer.session()->document();
  if (ImGui::MenuItem("Select")) tell_errors(viewer, document.select(items));
  if (ImGui::MenuItem("Hide")) tell_errors(viewer, document.hide(items));
  if (ImGui::MenuItem("Isolate")) tell_errors(viewer, document.isolate(items));
  if (ImGui::MenuItem("Make the rest faint")) tell_errors(viewer, document.ghost_others(items));
  ImGui::Separator();
  if (ImGui::MenuItem("Expand all below")) tree.rows().expand_all_below(node);
  if (ImGui::MenuItem("Copy name")) ImGui::SetClipboardText(label(viewer.session()->scene(), node).c_str());
  ImGui::EndPopup();
}

/// Returns whether the row was opened or closed, after which the rows are others.
bool node_row(Viewer& viewer, const TreeRow& row, ModelTree& tree) {
  const core::Scene& scene = viewer.session()->scene();
  const Document& document = viewer.session()->document();
  const core::ItemId first = scene.first_item(row.node);
  const bool selected = first != core::kNoItem && document.is(first, Document::kSelected);
  const bool hidden = first != core::kNoItem && document.is(first, Document::kHidden);
  ImGui::PushID(int(row.node.index));
  ImGui::Indent(0.7f * ImGui::GetFontSize() * float(row.depth) + 0.001f);
  ImGuiTreeNodeFlags flags =
      ImGuiTreeNodeFlags_NoTreePushOnOpen | ImGuiTreeNodeFlags_OpenOnArrow | ImGuiTreeNodeFlags_SpanFullWidth;
  if (!row.has_children) flags |= ImGuiTreeNodeFlags_Leaf;
  if (selected) flags |= ImGuiTreeNodeFlags_Selected;
  ImGui::SetNextItemOpen(row.expanded);
  std::string text = label(scene, row.node);
  if (row.items > 1) text += "  (" + std::to_string(row.items) + ")";
  const ImVec4 match(0.95f, 0.6f, 0.15f, 1.0f), faint = ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled);
  if (row.match || hidden) ImGui::PushStyleColor(ImGuiCol_Text, hidden ? faint : match);
  const bool open = ImGui::TreeNodeEx("##node", flags, "%s", text.c_str());
  if (row.match || hidden) ImGui::PopStyleColor();
  const bool toggled = ImGui::IsItemToggledOpen();
  if (ImGui::IsItemClicked() && !toggled) {
    select_below(viewer, row.node);
    if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) tell_errors(viewer, find_command("focus")->run(viewer, {}));
  }
  node_menu(viewer, row.node, tree);
  ImGui::Unindent(0.7f * ImGui::GetFontSize() * float(row.depth) + 0.001f);
  ImGui::PopID();
  if (toggled) open ? tree.rows().expand(row.node) : tree.rows().collapse(row.node);
  return toggled;
}

void rows(Viewer& viewer, ModelTree& tree) {
  ImGui::BeginChild("##rows", {0.0f, 0.0f}, false, ImGuiWindowFlags_HorizontalScrollbar);
  if (const auto revealed = tree.take_revealed()) {
    const float at = float(*revealed) * ImGui::GetTextLineHeightWithSpacing(), height = ImGui::GetWindowHeight();
    if (at < ImGui::GetScrollY() || at > ImGui::GetScrollY() + 0.9f * height)
      ImGui::SetScrollY(std::max(0.0f, at - 0.4f * height));
  }
  ImGuiListClipper clipper;
  clipper.Begin(int(tree.rows().row_count()), ImGui::GetTextLineHeightWithSpacing());
  bool changed = false;
  while (clipper.Step() && !changed)
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd && !changed; ++i)
      changed = node_row(viewer, tree.rows().row(std::size_t(i)), tree);
  clipper.End();
  ImGui::EndChild();
}

}  // namespace

void tree_panel(Viewer& viewer) {
  const Margins m = margins(viewer);
  begin_fixed("##tree", 0.0f, float(m.top), float(m.left), ImGui::GetIO().DisplaySize.y - float(m.top + m.bottom),
              ImGuiWindowFlags_NoTitleBar);
  if (Session* session = viewer.session()) {
    search_field(viewer, session->tree());
    rows(viewer, session->tree());
  }
  ImGui::End();
}

}  // namespace sightline::apps
