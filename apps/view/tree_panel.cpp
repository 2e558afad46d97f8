#include <algorithm>
#include <array>
#include <string>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "sightline/apps/common/short_text.h"
#include "sightline/apps/common/tree_walk.h"
#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/icons.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

void select_below(Workspace& work, core::NodeId node) {
  Document& document = work.session->document;
  const ImGuiIO& io = ImGui::GetIO();
  work.messages.tell_outcome(document.select(items_below(work.session->scene(), node), io.KeyCtrl ? SelectMode::kToggle
                                                                                       : io.KeyShift
                                                                                           ? SelectMode::kAdd
                                                                                           : SelectMode::kReplace));
}

/// Searches that are kept. A click looks for what they find, and selects it.
void sets(Workspace& work) {
  if (work.shown.sets.empty()) return;
  const std::string title = "Sets (" + std::to_string(work.shown.sets.size()) + ")###sets";
  if (!ImGui::CollapsingHeader(title.c_str())) return;
  const std::vector<std::string> all = work.shown.sets;  // commands change the list
  for (const std::string& set : all) {
    ImGui::PushID(set.c_str());
    if (ImGui::Selectable(shortened(set, ImGui::GetContentRegionAvail().x).c_str(),
                          work.session->tree.query().text == set)) {
      run(work, "find", set);
      run(work, "select-named", set);
    }
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s\nA click selects; the right button has more.", set.c_str());
    if (ImGui::BeginPopupContextItem()) {
      for (const char* name : {"hide", "isolate", "ghost-others"})
        if (ImGui::MenuItem(find_command(name)->title)) run(work, name, set);
      ImGui::Separator();
      if (ImGui::MenuItem("Remove the set")) run(work, "set-remove", set);
      ImGui::EndPopup();
    }
    ImGui::PopID();
  }
  ImGui::Separator();
}

void search_field(Workspace& work, ModelTree& tree) {
  NameQuery query = tree.query();
  const float button = ImGui::GetFrameHeight() + ImGui::GetStyle().ItemInnerSpacing.x + ImGui::CalcTextSize(".*").x;
  ImGui::SetNextItemWidth(-button - ImGui::GetStyle().ItemSpacing.x);
  if (work.shown.find) ImGui::SetKeyboardFocusHere();
  work.shown.find = false;
  bool changed = ImGui::InputTextWithHint("##find", "find: text, or attribute:text", &query.text);
  if (ImGui::IsItemHovered() && !ImGui::IsItemActive())
    ImGui::SetTooltip(
        "A text that names or values hold, or conditions:\n  System=CW & DN>=100 & @kind=cylinder\n"
        "  @size>500mm & @near<=1m of PUMP-1\n  ! before a condition: its opposite");
  if (ImGui::IsItemDeactivated() && ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape))) {
    changed |= !query.text.empty();  // Dear ImGui would bring back what was searched for before
    query.text.clear();
  }
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
  ImGui::Text("%s found", grouped(std::int64_t(tree.match_count())).c_str());
  ImGui::SameLine();
  if (ImGui::SmallButton("Select") || entered)
    work.messages.tell_outcome(select_found("", *work.session, work.messages));
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("What has exactly this name, or else these words, or else these letters");
  ImGui::SameLine();
  if (ImGui::SmallButton("Keep")) run(work, "set-keep");
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("Lists this search above the tree, where a click selects");
}

void node_menu(Workspace& work, core::NodeId node, ModelTree& tree) {
  if (!ImGui::BeginPopupContextItem()) return;
  const std::vector<core::ItemId> items = items_below(work.session->scene(), node);
  Document& document = work.session->document;
  if (ImGui::MenuItem("Select")) work.messages.tell_outcome(document.select(items));
  if (ImGui::MenuItem("Hide")) work.messages.tell_outcome(document.hide(items));
  if (ImGui::MenuItem("Isolate")) work.messages.tell_outcome(document.isolate(items));
  if (ImGui::MenuItem("Make the rest faint")) work.messages.tell_outcome(document.ghost_others(items));
  ImGui::Separator();
  if (ImGui::MenuItem("Expand all below")) tree.rows().expand_all_below(node);
  if (ImGui::MenuItem("Copy name")) ImGui::SetClipboardText(label(work.session->scene(), node).c_str());
  ImGui::EndPopup();
}

/// At the right end of a row: shows and hides what is below.
void eye(Workspace& work, const TreeRow& row, const TreeStates::Below& below, float x) {
  const float side = ImGui::GetTextLineHeight();
  ImGui::SameLine(x);
  if (ImGui::InvisibleButton("##eye", {side, side})) {
    Document& document = work.session->document;
    const std::vector<core::ItemId> items = items_below(work.session->scene(), row.node);
    work.messages.tell_outcome(below.hidden() ? document.show(items) : document.hide(items));
  }
  const bool hovered = ImGui::IsItemHovered();
  const char* icon = below.hidden() ? icons::kEyeClosed : below.partly_hidden() ? icons::kEyeHalf : icons::kEye;
  const float alpha = hovered || below.shown < below.items ? 1.0f : 0.35f;
  draw_icon(*ImGui::GetWindowDrawList(), icon, ImGui::GetItemRectMin(), side, ImGui::GetColorU32(ImGuiCol_Text, alpha));
  if (hovered)
    ImGui::SetTooltip("%s", below.hidden()          ? "hidden: a click shows it"
                            : below.partly_hidden() ? "partly hidden: a click hides all"
                                                    : "a click hides it");
}

/// The name, shortened where it has no room, and the number of items below.
void row_text(const TreeRow& row, std::string_view above, const std::string& name, const TreeStates::Below& below,
              bool selected, const std::array<float, 2>& columns) {
  const auto [x, end] = columns;
  const ImVec4 match(0.95f, 0.6f, 0.15f, 1.0f), faint = ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled);
  const std::string count = below.items > 1 ? grouped(below.items) : "";
  const float count_wide = count.empty() ? 0.0f : ImGui::CalcTextSize(count.c_str()).x + 0.5f * ImGui::GetFontSize();
  const std::string text = shortened_below(above, name, NarrowerThan{std::max(0.0f, end - x - count_wide)});
  ImGui::SameLine(x);
  ImGui::TextColored(below.hidden() ? faint
                     : row.match    ? match
                                    : ImGui::GetStyleColorVec4(ImGuiCol_Text),
                     "%s", text.c_str());
  if (count.empty()) return;
  ImGui::SameLine(end - ImGui::CalcTextSize(count.c_str()).x);
  ImGui::TextColored(selected ? ImGui::GetStyleColorVec4(ImGuiCol_Text) : faint, "%s", count.c_str());
}

/// Returns whether the row was opened or closed, after which the rows are others.
bool node_row(Workspace& work, const TreeRow& row, ModelTree& tree) {
  Session& session = *work.session;
  const core::ItemId first = session.scene().first_item(row.node);
  const TreeStates::Below below = session.tree_states().below(tree.rows(), row.node);
  const float font = ImGui::GetFontSize(), indent = 0.7f * font * float(row.depth),
              end = ImGui::GetWindowContentRegionMax().x;
  ImGui::PushID(int(row.node.index));
  ImGuiTreeNodeFlags flags = ImGuiTreeNodeFlags_NoTreePushOnOpen | ImGuiTreeNodeFlags_OpenOnArrow |
                             ImGuiTreeNodeFlags_SpanFullWidth | ImGuiTreeNodeFlags_AllowItemOverlap;
  if (!row.has_children) flags |= ImGuiTreeNodeFlags_Leaf;
  if (first != core::kNoItem && session.document.is(first, Document::kSelected)) flags |= ImGuiTreeNodeFlags_Selected;
  ImGui::SetNextItemOpen(row.expanded);
  ImGui::Indent(indent + 0.001f);
  const float x = ImGui::GetCursorPosX() + ImGui::GetTreeNodeToLabelSpacing();
  const bool open = ImGui::TreeNodeEx("##node", flags), toggled = ImGui::IsItemToggledOpen();
  ImGui::Unindent(indent + 0.001f);
  if (ImGui::IsItemClicked() && !toggled) {
    select_below(work, row.node);
    if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) run(work, "focus");
  }
  const std::string name = label(session.scene(), row.node);
  const float name_end = end - 1.4f * font;
  if (ImGui::IsItemHovered() && ImGui::CalcTextSize(name.c_str()).x > name_end - x - 2.0f * font)
    ImGui::SetTooltip("%s", name.c_str());
  node_menu(work, row.node, tree);
  const core::NodeId above = session.scene().parent(row.node);
  row_text(row, above.valid() ? session.scene().name(above) : std::string_view(), name, below,
           (flags & ImGuiTreeNodeFlags_Selected) != 0, {x, name_end});
  if (below.items > 0) eye(work, row, below, end - 1.1f * font);
  ImGui::PopID();
  if (toggled) open ? tree.rows().expand(row.node) : tree.rows().collapse(row.node);
  return toggled;
}

void rows(Workspace& work, ModelTree& tree) {
  ImGui::BeginChild("##rows");
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
      changed = node_row(work, tree.rows().row(std::size_t(i)), tree);
  clipper.End();
  ImGui::EndChild();
}

}  // namespace

void tree_panel(Workspace& work) {
  const Margins m = margins(work.shown);
  begin_fixed("##tree", 0.0f, float(m.top), float(m.left), ImGui::GetIO().DisplaySize.y - float(m.top + m.bottom),
              ImGuiWindowFlags_NoTitleBar);
  if (Session* session = work.session.get()) {
    search_field(work, session->tree);
    sets(work);
    rows(work, session->tree);
  }
  ImGui::End();
}

}  // namespace sightline::apps
