// What the viewer can be told: by keys, menus and scripts alike.
#pragma once

#include <span>
#include <string>

#include "sightline/apps/view/viewer.h"

namespace sightline::apps {

struct Command {
  const char* name;       ///< for scripts
  const char* group;      ///< its menu; null: in none
  const char* title;      ///< in the menu
  int key = 0, mods = 0;  ///< GLFW's numbers; 0: none
  const char* keys = "";  ///< as the user reads them
  const char* help;
  core::Expected<void> (*run)(Viewer& viewer, const std::string& argument);
  bool (*on)(Viewer& viewer) = nullptr;  ///< of a switch: whether it is on
  bool needs_model = true;
};

std::span<const Command> commands();
const Command* find_command(const std::string& name);
const Command* find_command(int key, int mods);

/// Lines for --help and scripts.
std::string command_list();

/// What is done with the mouse and with held keys, as pairs of what and how.
struct Gesture {
  const char *how, *what;
};
std::span<const Gesture> gestures();

}  // namespace sightline::apps
