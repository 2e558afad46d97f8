#include "sightline/apps/view/file_dialog.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <utility>
#include <vector>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "sightline/apps/common/numbers.h"
#include "sightline/apps/view/file_questions.h"
#include "sightline/apps/view/icons.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

namespace fs = std::filesystem;

constexpr float kWidth = 60.0f, kLeastList = 4.0f, kMostList = 26.0f;           // lines of text
constexpr float kPlaces = 11.0f, kFilter = 13.0f, kSize = 6.0f, kDate = 10.0f;  // widths, in lines
constexpr float kWidthForPlaces = 36.0f, kWidthForFacts = 24.0f, kMostCrumb = 14.0f, kButton = 7.0f;  // in lines
constexpr float kOtherRows = 9.0f;  // frames above and below the list
constexpr double kRefresh = 2.0;    // seconds

std::string date_text(const fs::file_time_type& time) {
  const auto whole = std::chrono::floor<std::chrono::seconds>(std::chrono::file_clock::to_sys(time));
  const std::time_t seconds = std::chrono::system_clock::to_time_t(whole);
  char text[32] = "";
  if (const std::tm* parts = std::localtime(&seconds)) std::strftime(text, sizeof text, "%Y-%m-%d %H:%M", parts);
  return text;
}

std::string filter_text(const FileFormat& filter) {
  std::string text;
  for (const std::string& extension : filter.extensions) text += (text.empty() ? "" : " ") + extension;
  return text;
}

bool pressed(ImGuiKey key, bool repeats) {
  return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key), repeats);
}

bool pressed_enter() {
  return pressed(ImGuiKey_Enter, false) || pressed(ImGuiKey_KeyPadEnter, false);
}

}  // namespace

fs::path& FileDialog::last_folder() {
  return last_folders_[question_->models ? 0 : 1];
}

void FileDialog::begin(Workspace& work) {
  places_ = places(work.files(), work.shown.recent);
  fs::path folder = last_folder();
  for (const auto& files : {work.files(), work.shown.recent})
    if (folder.empty() && !files.empty()) folder = fs::path(files.front()).parent_path();
  browser_.begin(question_->request(work), folder.empty() ? "." : folder);
  field_.clear();
  refresh_at_ = ImGui::GetTime() + kRefresh;
}

void FileDialog::draw(Workspace& work) {
  const FileQuestion* question = file_question(work.shown.dialog);
  if (question != std::exchange(question_, question)) {
    browser_ = {};
    if (question) begin(work);
  }
  if (!question) return;
  if (ImGui::GetTime() > refresh_at_) {
    browser_.refresh();
    refresh_at_ = ImGui::GetTime() + kRefresh;
  }
  const float font = ImGui::GetFontSize(), gap = ImGui::GetStyle().ItemSpacing.x;
  begin_dialog(work, question->title, kWidth);
  accepts_ = false;
  keys();
  breadcrumb();
  const float wide = ImGui::GetContentRegionAvail().x, row = ImGui::GetFrameHeightWithSpacing();
  const float high =
      std::clamp(0.95f * ImGui::GetIO().DisplaySize.y - kOtherRows * row, kLeastList * row, kMostList * font);
  if (wide > kWidthForPlaces * font) {
    place_list(kPlaces * font, high);
    ImGui::SameLine(0.0f, gap);
  }
  list(high);
  name_field();
  if (!browser_.error().empty()) {
    ImGui::PushStyleColor(ImGuiCol_Text, kErrorColour);
    wrapped_text(browser_.error());
    ImGui::PopStyleColor();
  }
  if (question->options) question->options(work);
  accepts_ |= ImGui::Button(question->button, {kButton * font, 0.0f});
  ImGui::SameLine();
  if (ImGui::Button("Cancel", {kButton * font, 0.0f})) work.shown.dialog = question->then;
  if (accepts_) accept(work);
  replace_question(work);
  ImGui::End();
}

/// The field of the name has the keyboard but for these keys.
void FileDialog::keys() {
  const bool other = ImGui::IsAnyItemActive() && !field_active_;
  if (other || !ImGui::IsWindowFocused(ImGuiFocusedFlags_RootAndChildWindows) ||
      ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup))
    return;
  if (pressed(ImGuiKey_Backspace, false) &&
      (browser_.typed().empty() || (browser_.typed_by_row() && field_all_selected_))) {
    browser_.go_up();
    scrolls_ = true;
  }
  for (const auto& [key, rows] : {std::pair{ImGuiKey_UpArrow, -1},
                                  {ImGuiKey_DownArrow, 1},
                                  {ImGuiKey_PageUp, -page_},
                                  {ImGuiKey_PageDown, page_}}) {
    if (!pressed(key, true)) continue;
    browser_.move(rows, ImGui::GetIO().KeyShift);
    scrolls_ = true;
  }
  if (!ImGui::IsAnyItemActive()) accepts_ |= pressed_enter();
}

/// As many of the last parts as fit.
void FileDialog::breadcrumb() {
  const float font = ImGui::GetFontSize(), padding = 2.0f * ImGui::GetStyle().FramePadding.x,
              gap = 0.5f * ImGui::GetStyle().ItemSpacing.x;
  const std::vector<Place> parts = browser_.breadcrumb();
  std::vector<std::string> labels;
  for (const Place& part : parts) labels.push_back(shortened(part.name, kMostCrumb * font));
  float room = ImGui::GetContentRegionAvail().x - 2.0f * (ImGui::GetFrameHeight() + gap) - padding;
  std::size_t first = parts.size();
  while (first > 0 && (room -= ImGui::CalcTextSize(labels[first - 1].c_str()).x + padding + gap) >= 0.0f) --first;
  std::optional<fs::path> chosen;
  ImGui::BeginDisabled(parts.size() < 2);
  if (ImGui::ArrowButton("##up", ImGuiDir_Up)) browser_.go_up();
  ImGui::EndDisabled();
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("the folder above (Backspace)");
  if (first > 0) {
    ImGui::SameLine(0.0f, gap);
    if (ImGui::Button("…")) chosen = parts[first - 1].folder;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", parts[first - 1].folder.string().c_str());
  }
  for (std::size_t i = first; i < parts.size(); ++i) {
    ImGui::SameLine(0.0f, gap);
    ImGui::PushID(int(i));
    if (ImGui::Button(labels[i].c_str())) chosen = parts[i].folder;
    ImGui::PopID();
  }
  if (chosen) browser_.enter(*chosen);
}

void FileDialog::place_list(float width, float height) {
  if (ImGui::BeginChild("##places", {width, height}, true)) {
    for (const Place& place : places_) {
      ImGui::PushID(&place);
      const std::string name = shortened(place.name, ImGui::GetContentRegionAvail().x);
      if (ImGui::Selectable(name.c_str(), place.folder == browser_.folder())) browser_.enter(place.folder);
      if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", place.folder.string().c_str());
      ImGui::PopID();
    }
  }
  ImGui::EndChild();
}

void FileDialog::list(float height) {
  constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_Sortable | ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg |
                                     ImGuiTableFlags_BordersOuter | ImGuiTableFlags_BordersInnerV;
  const float font = ImGui::GetFontSize(), room = ImGui::GetContentRegionAvail().x;
  if (!ImGui::BeginTable("##files", 3, kFlags, {0.0f, height})) return;
  ImGui::TableSetupScrollFreeze(0, 1);
  ImGui::TableSetupColumn("Name", ImGuiTableColumnFlags_WidthStretch | ImGuiTableColumnFlags_DefaultSort);
  const ImGuiTableColumnFlags beside =
      ImGuiTableColumnFlags_WidthFixed | (room < kWidthForFacts * font ? ImGuiTableColumnFlags_Disabled : 0);
  ImGui::TableSetupColumn("Size", beside, kSize * font);
  ImGui::TableSetupColumn("Changed", beside, kDate * font);
  if (ImGuiTableSortSpecs* specs = ImGui::TableGetSortSpecs(); specs && specs->SpecsDirty && specs->SpecsCount > 0) {
    browser_.sort(FileBrowser::Column(specs->Specs[0].ColumnIndex),
                  specs->Specs[0].SortDirection == ImGuiSortDirection_Ascending);
    specs->SpecsDirty = false;
  }
  ImGui::TableHeadersRow();
  rows(height);
  ImGui::EndTable();
}

void FileDialog::rows(float height) {
  const float text = ImGui::GetTextLineHeight(), pitch = text + 2.0f * ImGui::GetStyle().CellPadding.y;
  page_ = std::max(1, int(height / pitch) - 2);
  if (std::exchange(scrolls_, false) && browser_.cursor()) {
    const float at = float(*browser_.cursor()) * pitch, seen = float(page_) * pitch;
    if (at < ImGui::GetScrollY() || at > ImGui::GetScrollY() + seen)
      ImGui::SetScrollY(std::max(0.0f, at - 0.5f * seen));
  }
  std::optional<std::size_t> clicked, entered;
  ImGuiListClipper clipper;
  clipper.Begin(int(browser_.row_count()), pitch);
  while (clipper.Step())
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
      const FolderEntry& entry = browser_.row(std::size_t(i));
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::PushID(i);
      const ImVec2 at = ImGui::GetCursorScreenPos();
      const bool lit = browser_.chosen(std::size_t(i)) || browser_.cursor() == std::size_t(i);
      if (ImGui::Selectable("##row", lit, ImGuiSelectableFlags_SpanAllColumns | ImGuiSelectableFlags_AllowDoubleClick))
        (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left) ? entered : clicked) = std::size_t(i);
      const float room = ImGui::GetContentRegionAvail().x - 1.4f * text;
      if (ImGui::IsItemHovered() && ImGui::CalcTextSize(entry.name.c_str()).x > room)
        ImGui::SetTooltip("%s", entry.name.c_str());
      ImGui::SameLine(0.0f, 0.0f);
      if (entry.folder)
        draw_icon(*ImGui::GetWindowDrawList(), icons::kOpen, at, text, ImGui::GetColorU32(ImGuiCol_Text));
      ImGui::SetCursorScreenPos({at.x + 1.4f * text, at.y});
      ImGui::TextUnformatted(entry.name.c_str());
      const FileState& state = browser_.state(std::size_t(i));
      if (ImGui::TableNextColumn() && !entry.folder && state.there)
        ImGui::TextUnformatted(bytes_text(state.bytes).c_str());
      if (ImGui::TableNextColumn() && state.there) ImGui::TextUnformatted(date_text(state.changed).c_str());
      ImGui::PopID();
    }
  clipper.End();
  if (browser_.row_count() == 0 && browser_.error().empty()) {
    ImGui::TableNextColumn();
    ImGui::TextDisabled("nothing of these formats is here");
  }
  const ImGuiIO& io = ImGui::GetIO();
  if (clicked)
    browser_.choose(*clicked, io.KeyShift  ? FileBrowser::Choose::kRange
                              : io.KeyCtrl ? FileBrowser::Choose::kToggle
                                           : FileBrowser::Choose::kAlone);
  if (!entered) return;
  if (browser_.row(*entered).folder) return browser_.enter(browser_.folder() / browser_.row(*entered).name);
  browser_.choose(*entered, FileBrowser::Choose::kAlone);
  accepts_ = true;
}

/// What rows and folders do to the name while its field is active, which otherwise keeps its own text.
void FileDialog::take_name(ImGuiInputTextCallbackData& field) {
  if (browser_.typed() != field_) {
    field.DeleteChars(0, field.BufTextLen);
    field.InsertChars(0, browser_.typed().c_str());
    field.SelectAll();
    field_ = browser_.typed();
  }
  field_all_selected_ = std::abs(field.SelectionEnd - field.SelectionStart) == field.BufTextLen;
}

void FileDialog::name_field() {
  const float font = ImGui::GetFontSize(), gap = ImGui::GetStyle().ItemSpacing.x;
  const std::vector<FileFormat>& filters = browser_.filters();
  if (ImGui::IsWindowFocused(ImGuiFocusedFlags_RootAndChildWindows) && !ImGui::IsAnyItemActive() &&
      !ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup))
    ImGui::SetKeyboardFocusHere();
  const std::size_t chosen = browser_.chosen_count();
  const std::string hint = chosen > 1 ? std::to_string(chosen) + " files" : "name or path";
  const auto take = [](ImGuiInputTextCallbackData* data) {
    static_cast<FileDialog*>(data->UserData)->take_name(*data);
    return 0;
  };
  const float filter_wide = std::min(kFilter * font, 0.4f * ImGui::GetContentRegionAvail().x);
  ImGui::SetNextItemWidth(filters.empty() ? -1.0f : -filter_wide - gap);
  std::string text = browser_.typed();
  accepts_ |=
      ImGui::InputTextWithHint("##name", hint.c_str(), &text,
                               ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_CallbackAlways, take, this);
  field_active_ = ImGui::IsItemActive();
  if (text != browser_.typed()) {
    browser_.type(text);
    scrolls_ = true;
  }
  if (field_active_) field_ = text;
  if (filters.empty()) return;
  ImGui::SameLine();
  ImGui::SetNextItemWidth(-1.0f);
  if (!ImGui::BeginCombo("##filter", filters[browser_.filter()].name.c_str())) return;
  for (std::size_t i = 0; i < filters.size(); ++i) {
    if (ImGui::Selectable(filters[i].name.c_str(), i == browser_.filter())) browser_.set_filter(i);
    if (ImGui::IsItemHovered() && !filters[i].extensions.empty())
      ImGui::SetTooltip("%s", filter_text(filters[i]).c_str());
  }
  ImGui::EndCombo();
}

void FileDialog::replace_question(Workspace& work) {
  constexpr const char* kName = "Replace";
  if (!browser_.asks_to_replace()) return;
  if (accepts_) ImGui::OpenPopup(kName);
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * screen.x, 0.5f * screen.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(30.0f * ImGui::GetFontSize(), 0.9f * screen.x), 0.0f});
  if (!ImGui::BeginPopupModal(kName, nullptr, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings))
    return browser_.keep();  // closed by Esc
  wrapped_text(browser_.asks_to_replace()->filename().string() + " is there already. Replace it?");
  const bool replaces = ImGui::Button("Replace") || (pressed_enter() && !ImGui::IsWindowAppearing());
  ImGui::SameLine();
  const bool keeps = ImGui::Button("Keep it");
  if (replaces || keeps) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
  if (replaces)
    answer(work, browser_.replace());
  else if (keeps)
    browser_.keep();
}

void FileDialog::accept(Workspace& work) {
  scrolls_ = true;
  if (const auto files = browser_.accept()) answer(work, *files);
}

/// The dialog stays where that fails.
void FileDialog::answer(Workspace& work, const std::vector<fs::path>& files) {
  std::vector<std::string> names;
  for (const fs::path& file : files) names.push_back(file.string());
  if (const auto done = question_->answer(work, names); !done) return browser_.say(done.error().message);
  last_folder() = files.front().parent_path();
  if (work.shown.dialog == question_->dialog) work.shown.dialog = question_->then;
}

json::Value FileDialog::state() const {
  if (!question_) return nullptr;
  const auto cursor = browser_.cursor();
  return {{"folder", browser_.folder().string()},
          {"rows", browser_.row_count()},
          {"row", cursor ? browser_.row(*cursor).name : ""},
          {"chosen", browser_.chosen_count()},
          {"name", browser_.typed()},
          {"error", browser_.error()},
          {"replaces", browser_.asks_to_replace().has_value()}};
}

}  // namespace sightline::apps
