#include "sightline/apps/view/widgets.h"

#include <algorithm>
#include <sstream>

#include "sightline/apps/common/short_text.h"

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

void begin_dialog(Workspace& work, const char* name, float lines_wide) {
  bool open = true;
  begin_centred(name, &open, lines_wide);
  if (!open) work.shown.dialog = Dialog::kNone;
}

void wrapped_text(const std::string& text) {
  const float wide = ImGui::GetContentRegionAvail().x;
  const auto fits = [wide](const std::string& line) { return ImGui::CalcTextSize(line.c_str()).x <= wide; };
  std::string lines, line;
  bool words_fit = true;
  std::istringstream in(unbroken(text));
  for (std::string paragraph; std::getline(in, paragraph); line.clear()) {
    if (!lines.empty()) lines += '\n';
    for (std::size_t at = 0; at <= paragraph.size();) {
      const std::size_t space = std::min(paragraph.find(' ', at), paragraph.size());
      const std::string word = paragraph.substr(at, space - at);
      words_fit = words_fit && fits(word);
      if (at > 0 && !fits(line + " " + word)) {
        lines += line + '\n';
        line = word;
      } else {
        line += (at > 0 ? " " : "") + word;
      }
      at = space + 1;
    }
    lines += line;
  }
  // A single word that is too long, such as a path, ends lines anywhere.
  ImGui::PushTextWrapPos(words_fit ? -1.0f : 0.0f);
  ImGui::TextUnformatted(lines.c_str());
  ImGui::PopTextWrapPos();
}

void row(const char* name, const std::string& value) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  wrapped_text(name);
  ImGui::TableNextColumn();
  wrapped_text(value);
}

bool begin_rows(const char* name) {
  if (!ImGui::BeginTable(name, 2, ImGuiTableFlags_RowBg | ImGuiTableFlags_BordersInnerV)) return false;
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed,
                          std::min(7.0f * ImGui::GetFontSize(), 0.4f * ImGui::GetContentRegionAvail().x));
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch);
  return true;
}

void framed_image(const gl::Texture2D* image, const ImVec2& corner, const ImVec2& size, bool faint) {
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(corner, {corner.x + size.x, corner.y + size.y}, ImGui::GetColorU32(ImGuiCol_FrameBg, 0.5f));
  if (!image) return;
  const float fit = std::min(size.x / float(image->width()), size.y / float(image->height()));
  const ImVec2 half(0.5f * fit * float(image->width()), 0.5f * fit * float(image->height())),
      middle(corner.x + 0.5f * size.x, corner.y + 0.5f * size.y);
  list.AddImage(reinterpret_cast<ImTextureID>(std::uintptr_t(image->id())), {middle.x - half.x, middle.y - half.y},
                {middle.x + half.x, middle.y + half.y}, {0.0f, 0.0f}, {1.0f, 1.0f},
                ImGui::GetColorU32({1.0f, 1.0f, 1.0f, faint ? 0.35f : 1.0f}));
}

std::string shortened(const std::string& text, float width) {
  return shortened_to(text, NarrowerThan{width});
}

void command_tip(Workspace& work, const Command& command, bool titled) {
  ImGui::BeginTooltip();
  if (titled && command.keys[0] != '\0')
    ImGui::Text("%s (%s)", command.title, command.keys);
  else if (titled)
    ImGui::TextUnformatted(command.title);
  const char* obstacle = command.obstacle_now(work);
  ImGui::PushTextWrapPos(25.0f * ImGui::GetFontSize());
  ImGui::TextUnformatted(obstacle ? obstacle : help_of(command).c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

void command_item(Workspace& work, const Command& command) {
  const bool possible = !command.obstacle_now(work), on = possible && command.on && command.on(work);
  if (ImGui::MenuItem(command.title, command.keys, on, possible)) run(work, command);
  if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) command_tip(work, command, false);
}

void command_button(Workspace& work, const char* name, float right) {
  const Command& command = *find_command(name);
  const ImGuiStyle& style = ImGui::GetStyle();
  const float wide = ImGui::CalcTextSize(command.title).x + 2.0f * style.FramePadding.x;
  const bool possible = !command.obstacle_now(work), on = possible && command.on && command.on(work);
  if (ImGui::GetCursorScreenPos().x + wide > right) ImGui::NewLine();
  ImGui::BeginDisabled(!possible);
  if (on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
  if (ImGui::Button(command.title)) run(work, command);
  if (on) ImGui::PopStyleColor();
  ImGui::EndDisabled();
  if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) command_tip(work, command, true);
  ImGui::SameLine();
}

void run(Workspace& work, const Command& command, const std::string& argument) {
  if (const char* obstacle = command.obstacle_now(work)) return work.messages.tell(obstacle, true);
  work.messages.tell_outcome(command.run(work, argument));
}

void run(Workspace& work, const std::string& command, const std::string& argument) {
  run(work, *find_command(command), argument);
}

}  // namespace sightline::apps
