// What the viewer can be told: by keys, menus, toolbar and scripts alike, and what F1 and --help say of it.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "sightline/apps/view/obstacles.h"
#include "sightline/apps/view/viewer.h"

namespace sightline::apps {

struct Command {
  const char* name;       ///< for scripts
  const char* menu;       ///< "View", or "View/Shapes" for a submenu; "|View" begins a block; null: in no menu
  const char* title;      ///< in the menu
  int key = 0, mods = 0;  ///< GLFW's numbers; 0: none
  const char* keys = "";  ///< as the user reads them
  const char* help;
  core::Expected<void> (*run)(Viewer& viewer, const std::string& argument);
  bool (*on)(Viewer& viewer) = nullptr;  ///< of a switch: whether it is on
  /// What keeps it from having an effect, for the user; null: nothing. Null as a function: it is always possible.
  const char* (*obstacle)(Viewer& viewer) = &without_model;
  const char* icon = nullptr;  ///< in the toolbar (icons.h); null: not there

  bool needs_model() const { return obstacle != nullptr; }
  const char* obstacle_now(Viewer& viewer) const { return obstacle ? obstacle(viewer) : nullptr; }
};

std::span<const Command> commands();
/// Where a command stands, out of Command::menu.
struct MenuPlace {
  explicit MenuPlace(const Command& command);

  std::string_view menu, submenu;  ///< empty: in none
  bool begins_block = false;
};
/// What a command does, without the arguments that scripts give it.
std::string help_of(const Command& command);
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
