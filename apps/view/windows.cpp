#include <algorithm>
#include <cfloat>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "sightline/apps/common/gl_page.h"
#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

/// What is done in the image, then the commands that have keys, by menu.
struct HelpGroup {
  std::string title;
  std::vector<std::pair<std::string, std::string>> lines;  // how, what
};

std::vector<HelpGroup> help_groups() {
  std::vector<HelpGroup> groups{{"In the image", {}}};
  for (const Gesture& gesture : gestures()) groups[0].lines.emplace_back(gesture.how, gesture.what);
  std::string menu = "File";
  for (const Command& command : commands()) {
    if (command.menu) menu = MenuPlace(command).menu;
    if (command.keys[0] == '\0') continue;
    if (groups.back().title != menu) groups.push_back({menu, {}});
    groups.back().lines.emplace_back(command.keys, help_of(command));
  }
  return groups;
}

void help_column(std::span<const HelpGroup> groups) {
  for (const HelpGroup& group : groups) {
    ImGui::TextColored(ImGui::GetStyleColorVec4(ImGuiCol_CheckMark), "%s", group.title.c_str());
    if (!ImGui::BeginTable(group.title.c_str(), 2, ImGuiTableFlags_RowBg)) continue;
    ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed, 8.5f * ImGui::GetFontSize());
    ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch);
    for (const auto& [how, what] : group.lines) {
      ImGui::TableNextColumn();
      ImGui::TextWrapped("%s", how.c_str());
      ImGui::TableNextColumn();
      ImGui::TextWrapped("%s", what.c_str());
    }
    ImGui::EndTable();
  }
}

void help_window(Workspace& work) {
  constexpr float kColumnLines = 34.0f;
  const float font = ImGui::GetFontSize();
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  begin_dialog(work, "Keys and mouse", 2.0f * kColumnLines + 4.0f);
  const std::vector<HelpGroup> groups = help_groups();
  const bool two = ImGui::GetContentRegionAvail().x > 1.6f * kColumnLines * font;
  std::size_t left = groups.size(), lines = 0, all = 0;
  for (const HelpGroup& group : groups) all += group.lines.size() + 1;
  for (std::size_t i = 1; two && i < groups.size() && left == groups.size(); ++i)
    if ((lines += groups[i - 1].lines.size() + 1) + groups[i].lines.size() > 3 * all / 5) left = i;
  ImGui::BeginChild("##help", {0.0f, std::min(0.85f * screen.y, (two ? 54.0f : 70.0f) * font)});
  if (ImGui::BeginTable("##columns", two ? 2 : 1)) {
    ImGui::TableNextColumn();
    help_column(std::span(groups).first(left));
    ImGui::TableNextColumn();
    if (two) help_column(std::span(groups).subspan(left));
    ImGui::EndTable();
  }
  ImGui::EndChild();
  ImGui::End();
}

/// The page sets its values into a column for fonts whose characters are of one width.
void gl_page_lines(const std::string& text) {
  const float column = 17.0f * ImGui::GetFontSize();
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const bool row = line.size() > kGlPageColumn && line[kGlPageColumn - 1] == ' ';
    const std::size_t end = row ? line.find_last_not_of(' ', kGlPageColumn - 1) + 1 : line.size();
    ImGui::TextUnformatted(line.substr(0, end).c_str());
    if (!row) continue;
    ImGui::SameLine(column);
    wrapped_text(line.substr(kGlPageColumn));
  }
}

void driver_window(Workspace& work) {
  static std::string text;  // of when it was opened: asking for extensions takes a while
  begin_dialog(work, "Graphics driver", 64.0f);
  if (ImGui::IsWindowAppearing()) text = gl_page_text(gl_page(work.window.context()));
  if (ImGui::Button("Copy")) ImGui::SetClipboardText(text.c_str());
  ImGui::BeginChild("##driver", {0.0f, std::min(0.7f * ImGui::GetIO().DisplaySize.y, 40.0f * ImGui::GetFontSize())},
                    true);
  gl_page_lines(text);
  ImGui::EndChild();
  ImGui::End();
}

void quit_window(Workspace& work) {
  begin_dialog(work, "Quit", 34.0f);
  const std::size_t unsaved = work.views.unsaved();
  ImGui::TextWrapped("%zu view%s of the list %s in no file, and would be lost.", unsaved, unsaved == 1 ? "" : "s",
                     unsaved == 1 ? "is" : "are");
  if (work.session_file.empty()) {
    if (ImGui::Button("Save and quit…")) work.shown.dialog = Dialog::kSaveAndQuit;
  } else if (ImGui::Button("Save the session and quit")) {
    const Done saved = save_session(work, work.session_file);
    work.messages.tell_outcome(saved);
    if (saved) work.window.close();
  }
  ImGui::SameLine();
  if (ImGui::Button("Quit without them")) work.window.close();
  ImGui::SameLine();
  if (ImGui::Button("Stay")) work.shown.dialog = Dialog::kNone;
  ImGui::End();
}

}  // namespace

void dialog_window(Workspace& work) {
  work.file_dialog.draw(work);
  switch (work.shown.dialog) {
    case Dialog::kHelp:
      return help_window(work);
    case Dialog::kDriver:
      return driver_window(work);
    case Dialog::kQuit:
      return quit_window(work);
    case Dialog::kPath:
      return path_window(work);
    default:
      return;
  }
}

void loading_window(Opening& opening, const Messages& messages) {
  const bool whole = opening.first_image() != nullptr;
  const std::size_t seen = opening.preview() && !whole ? opening.preview()->items() : 0;
  begin_centred("Reading", nullptr, 30.0f, whole || seen > 0 ? 0.85f : 0.5f);
  ImGui::TextWrapped("%s", messages.text().c_str());
  if (seen > 0) ImGui::TextWrapped("Shown: the largest %s items so far", grouped(std::int64_t(seen)).c_str());
  const double progress = opening.progress();
  const std::string step = std::string(opening.steps().name()) + ", " + std::to_string(int(100.0 * progress)) + " %";
  ImGui::ProgressBar(float(progress), {-FLT_MIN, 0.0f}, step.c_str());
  if (ImGui::Button("Cancel")) opening.cancel();
  ImGui::End();
}

}  // namespace sightline::apps
