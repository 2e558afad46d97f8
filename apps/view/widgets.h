// What panels are made of.
#pragma once

#include <cstdint>
#include <string>

#include <imgui.h>

#include "sightline/apps/common/numbers.h"
#include "sightline/apps/view/commands.h"

namespace sightline::apps {

/// Windows that stay where they are put, and in the middle, or with their middle at another part of the height;
/// ImGui::End() ends them. A dialog has a button that closes it.
void begin_fixed(const char* name, float x, float y, float width, float height, ImGuiWindowFlags flags = 0);
void begin_centred(const char* name, bool* open, float lines_wide, float at_height = 0.5f);

void begin_dialog(Viewer& viewer, const char* name, float lines_wide);

/// A table of names and values; ImGui::EndTable() ends it where this is true.
bool begin_rows(const char* name);
void row(const char* name, const std::string& value);

/// Runs a command and tells its error.
void run(Viewer& viewer, const Command& command);

}  // namespace sightline::apps
