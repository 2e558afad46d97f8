// What panels are made of.
#pragma once

#include <cstdint>
#include <string>

#include <imgui.h>

#include "sightline/apps/common/numbers.h"
#include "sightline/apps/view/commands.h"
#include "sightline/gl/internal/texture.h"

namespace sightline::apps {

inline const ImVec4 kErrorColour{0.95f, 0.45f, 0.25f, 1.0f};

/// Windows that stay where they are put, and in the middle, or with their middle at another part of the height;
/// ImGui::End() ends them. A dialog has a button that closes it.
void begin_fixed(const char* name, float x, float y, float width, float height, ImGuiWindowFlags flags = 0);
void begin_centred(const char* name, bool* open, float lines_wide, float at_height = 0.5f);

void begin_dialog(Workspace& work, const char* name, float lines_wide);

/// A text that is wrapped between words alone. ImGui's TextWrapped() ends lines within numbers, too, after points and
/// commas.
void wrapped_text(const std::string& text);

/// A table of names and values; ImGui::EndTable() ends it where this is true.
bool begin_rows(const char* name);
void row(const char* name, const std::string& value);

/// Runs a command, and tells its error or what keeps it from having an effect.
void run(Workspace& work, const Command& command, const std::string& argument = {});
void run(Workspace& work, const std::string& command, const std::string& argument = {});
/// The command as an entry of a menu, grey where it is impossible, with its tooltip.
void command_item(Workspace& work, const Command& command);
/// The command as a button, on the same line as the one before if it ends before `right`, a place of the screen.
void command_button(Workspace& work, const char* name, float right);
/// What the command does, or what keeps it from it; with its title and key where these are not beside it.
void command_tip(Workspace& work, const Command& command, bool titled);

/// An image within a rectangle of the screen, as large as fits, or a plain rectangle where there is none (null).
void framed_image(const gl::Texture2D* image, const ImVec2& corner, const ImVec2& size, bool faint = false);

/// Whether a text is at most so many pixels wide.
struct NarrowerThan {
  float width;
  bool operator()(std::string_view text) const {
    return ImGui::CalcTextSize(text.data(), text.data() + text.size()).x <= width;
  }
};
/// shortened_to() a width of pixels.
std::string shortened(const std::string& text, float width);

}  // namespace sightline::apps
