#include "sightline/apps/view/widgets.h"

#include <algorithm>

namespace sightline::apps {

void begin_fixed(const char* name, float x, float y, float width, float height, ImGuiWindowFlags flags) {
  ImGui::SetNextWindowPos({x, y});
  ImGui::SetNextWindowSize({width, height});
  ImGui::Begin(name, nullptr,
               flags | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus);
}

void begin_centred(const char* name, bool* open, float lines_wide, float at_height) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * size.x, at_height * size.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(lines_wide * ImGui::GetFontSize(), 0.95f * size.x), 0.0f});
  ImGui::Begin(name, open, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings);
}

void begin_dialog(Viewer& viewer, const char* name, float lines_wide) {
  bool open = true;
  begin_centred(name, &open, lines_wide);
  if (!open) viewer.shown.dialog = Dialog::kNone;
}

void row(const char* name, const std::string& value) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(name);
  ImGui::TableNextColumn();
  ImGui::PushTextWrapPos(0.0f);
  ImGui::TextUnformatted(value.c_str());
  ImGui::PopTextWrapPos();
}

bool begin_rows(const char* name) {
  if (!ImGui::BeginTable(name, 2, ImGuiTableFlags_RowBg | ImGuiTableFlags_BordersInnerV)) return false;
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed, 7.0f * ImGui::GetFontSize());
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch);
  return true;
}

void run(Viewer& viewer, const Command& command) {
  if (auto done = command.run(viewer, {}); !done) viewer.tell(done.error().message, true);
}

}  // namespace sightline::apps
