// What the window shows while no model is open: how to open one, and how to move in it.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <imgui.h>

#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {
namespace {

namespace fs = std::filesystem;

/// An area that looks as if something could be put there: files can be dropped anywhere, but somebody has to know.
void drop_area(Workspace& work, float wide) {
  const float font = ImGui::GetFontSize(), high = 5.5f * font, dash = 0.6f * font;
  const ImVec2 at = ImGui::GetCursorScreenPos(), end(at.x + wide, at.y + high);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(at, end, ImGui::GetColorU32(ImGuiCol_FrameBg, 0.35f), 0.3f * font);
  const ImU32 colour = ImGui::GetColorU32(ImGuiCol_TextDisabled);
  const float line = std::max(1.0f, font / 12.0f);
  for (float x = at.x; x < end.x; x += 2.0f * dash)
    for (const float y : {at.y, end.y}) list.AddLine({x, y}, {std::min(x + dash, end.x), y}, colour, line);
  for (float y = at.y; y < end.y; y += 2.0f * dash)
    for (const float x : {at.x, end.x}) list.AddLine({x, y}, {x, std::min(y + dash, end.y)}, colour, line);
  const Command& open = *find_command("open");
  const std::string title = std::string(open.title) + "  " + open.keys;
  const char* words = "or drop files here";
  const ImVec2 button(std::min(12.0f * font, wide - 2.0f * font), 2.2f * font);
  const float both = button.x + font + ImGui::CalcTextSize(words).x;
  const bool beside = both < wide - 2.0f * font;
  const float x = ImGui::GetCursorPosX(), y = ImGui::GetCursorPosY(), left = 0.5f * (wide - (beside ? both : button.x));
  ImGui::SetCursorPos({x + left, y + (beside ? 0.5f * (high - button.y) : 0.7f * font)});
  if (ImGui::Button(title.c_str(), button)) run(work, open);
  if (beside) {
    ImGui::SameLine(0.0f, font);
    ImGui::SetCursorPosY(y + 0.5f * (high - font) - ImGui::GetStyle().FramePadding.y);  // the button's line adds that
  } else {
    ImGui::SetCursorPosX(x + 0.5f * (wide - ImGui::CalcTextSize(words).x));
  }
  ImGui::TextUnformatted(words);
  ImGui::SetCursorPos({x, y});
  ImGui::Dummy({wide, high});
}

/// What was open when the viewer was closed, as it was seen then.
void last_session(Workspace& work) {
  if (!work.last) return;
  const std::string title = "Continue with " + name_of_files(work.last->files);
  if (ImGui::Button(title.c_str())) return work.open(*work.last);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("View, sections, measurements and what is hidden come back, too");
}

/// Image, name and folder. True where it is clicked.
bool recent_model(Workspace& work, const std::string& file, const ImVec2& image, const ImVec2& cell) {
  const fs::path path(file);
  const bool there = work.file_states.of(file).there;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float line = ImGui::GetTextLineHeight(), inset = 0.5f * (cell.x - image.x);
  ImGui::BeginDisabled(!there);
  const bool clicked = ImGui::InvisibleButton("##model", cell);
  ImGui::EndDisabled();
  if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) {
    ImGui::SetTooltip("%s", file.c_str());
    ImGui::GetWindowDrawList()->AddRectFilled(
        at, {at.x + cell.x, at.y + cell.y}, ImGui::GetColorU32(there ? ImGuiCol_HeaderHovered : ImGuiCol_FrameBg, 0.6f),
        inset);
  }
  framed_image(work.textures.get(work.window.context(), file, [&] { return work.thumbnails.read(file); }),
               {at.x + inset, at.y + inset}, image, !there);
  const auto text = [&](const std::string& words, float y, ImGuiCol colour) {
    ImGui::GetWindowDrawList()->AddText({at.x + inset, y}, ImGui::GetColorU32(colour),
                                        shortened(words, image.x).c_str());
  };
  const float below = at.y + inset + image.y + 0.2f * line;
  text(path.filename().string(), below, there ? ImGuiCol_Text : ImGuiCol_TextDisabled);
  text(there ? path.parent_path().string() : "no longer there", below + line, ImGuiCol_TextDisabled);
  return clicked;
}

/// Files opened before, side by side as many as there is room for; a click opens one again.
void recent_models(Workspace& work, float wide) {
  constexpr float kLeastLines = 9.0f, kMostColumns = 5.0f;
  if (work.shown.recent.empty()) return;
  ImGui::TextDisabled("Recent models");
  const float font = ImGui::GetFontSize(), inset = 0.3f * font;
  const auto columns = std::size_t(std::clamp(std::floor(wide / (kLeastLines * font)), 1.0f, kMostColumns));
  const float across = std::floor((wide + 2.0f * inset) / float(columns));
  const ImVec2 image(across - 2.0f * inset, 0.75f * (across - 2.0f * inset)),
      cell(across, image.y + 2.0f * inset + 2.4f * ImGui::GetTextLineHeight());
  std::string chosen;
  for (std::size_t i = 0; i < work.shown.recent.size(); ++i) {
    if (i % columns != 0)
      ImGui::SameLine(0.0f, 0.0f);
    else
      ImGui::SetCursorPosX(ImGui::GetCursorPosX() - inset);
    ImGui::PushID(int(i));
    if (recent_model(work, work.shown.recent[i], image, cell)) chosen = work.shown.recent[i];
    ImGui::PopID();
  }
  if (!chosen.empty()) work.open({chosen});
}

void first_gestures() {
  constexpr std::size_t kFirst = 4;  // turning, moving, looking, coming nearer
  ImGui::TextDisabled("In the model");
  if (!begin_rows("gestures")) return;
  for (const Gesture& gesture : gestures().first(kFirst)) row(gesture.how, gesture.what);
  row("F1", "all keys and mouse");
  ImGui::EndTable();
}

}  // namespace

void start_page(Workspace& work, const apps::Part& part) {
  constexpr float kMostLines = 64.0f;
  if (work.session || work.opening.active()) return;
  const float font = ImGui::GetFontSize(), top = ImGui::GetIO().DisplaySize.y - float(part.y + part.height),
              wide = std::min(float(part.width), kMostLines * font);
  ImGui::PushStyleColor(ImGuiCol_Border, {0.0f, 0.0f, 0.0f, 0.0f});
  begin_fixed("##start", float(part.x) + 0.5f * (float(part.width) - wide), top, wide, float(part.height),
              ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoBackground);
  const float room = ImGui::GetContentRegionAvail().x;
  ImGui::Dummy({0.0f, 0.02f * float(part.height)});
  drop_area(work, room);
  ImGui::Dummy({0.0f, 0.5f * font});
  last_session(work);
  ImGui::Dummy({0.0f, 0.3f * font});
  recent_models(work, room);
  ImGui::Dummy({0.0f, 0.5f * font});
  first_gestures();
  ImGui::End();
  ImGui::PopStyleColor();
}

}  // namespace sightline::apps
