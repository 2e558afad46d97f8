// What the viewer can be told: by keys, menus, toolbar and scripts alike, and what F1 and --help say of it.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "sightline/apps/view/needs.h"
#include "sightline/apps/view/workspace.h"

namespace sightline::apps {

struct Command {
  const char* name;   ///< for scripts
  const char* menu;   ///< "View", or "View/Shapes" for a submenu; "|View" begins a block; null: in no menu
  const char* title;  ///< in the menu
  const char* keys;   ///< as the user reads them: "Ctrl+O"; empty: none
  const char* help;
  Done (*run)(Workspace& work, const std::string& argument);
  bool (*on)(Workspace& work) = nullptr;  ///< of a switch: whether it is on
  /// Null: it is always possible.
  const Need* need = &needs::kModel;
  const char* icon = nullptr;  ///< in the toolbar (icons.h); null: not there
  int key = 0, mods = 0;       ///< GLFW's numbers of `keys`, by bind()

  void bind();
  bool needs_model() const { return need != nullptr; }
  /// Returns what keeps it from having an effect, in words for the user; null where nothing does.
  const char* obstacle_now(Workspace& work) const { return need ? missing(*need, work) : nullptr; }
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
/// By the words of its menus: "Section, Through the middle, Horizontal".
const Command* find_in_menus(std::string_view words);

/// Lines for --help and scripts.
std::string command_list();

/// What is done with the mouse and with held keys, as pairs of what and how.
struct Gesture {
  const char *how, *what;
};
std::span<const Gesture> gestures();

}  // namespace sightline::apps
