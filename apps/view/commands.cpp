#include "sightline/apps/view/commands.h"

#include <cctype>
#include <cstdio>
#include <tuple>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "sightline/apps/view/script.h"

namespace sightline::apps {
namespace {

constexpr Gesture kGestures[] = {
    {"left drag", "turn about the point under the cursor"},
    {"middle drag, Shift + left drag", "move the model along"},
    {"right drag", "look about"},
    {"wheel", "come nearer to the point under the cursor"},
    {"W A S D, Q E", "fly forward, left, back, right; down, up; with Shift faster; on foot where K is on"},
    {"click", "select; Ctrl adds or takes away, Shift adds"},
    {"right click", "select, and open a menu"},
    {"Ctrl + left drag", "select what lies wholly in a rectangle; drawn from right to left: with any part in it"},
    {"double click", "focus on what is under the cursor"},
    {"handles of sections", "arrows move, sides turn (Ctrl: by round steps, Shift: to the model), middle: click flips"},
};

}  // namespace

std::span<const Gesture> gestures() {
  return kGestures;
}

MenuPlace::MenuPlace(const Command& command) {
  std::string_view text = command.menu ? command.menu : "";
  begins_block = text.starts_with('|');
  if (begins_block) text.remove_prefix(1);
  const std::size_t slash = text.find('/');
  menu = text.substr(0, slash);
  if (slash != std::string_view::npos) submenu = text.substr(slash + 1);
}

void Command::bind() {
  std::string text = keys;
  for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
  if (text.starts_with("keypad"))
    key = text.ends_with('+') ? GLFW_KEY_KP_ADD : GLFW_KEY_KP_SUBTRACT;
  else if (const auto events = events_of({0, "press", text}); events && !text.empty())
    std::tie(key, mods) = std::pair(events->front().key, events->front().mods);
}

std::string help_of(const Command& command) {
  const std::string help = command.help;
  const std::size_t colon = help.rfind(": ");
  const bool arguments = colon != std::string::npos && colon + 2 < help.size() &&
                         (std::isupper(help[colon + 2]) != 0 || std::isdigit(help[colon + 2]) != 0);
  std::string without = arguments ? help.substr(0, colon) : help;
  constexpr std::string_view kOfPart = ", or a part";  // which nobody names with the mouse
  if (arguments && without.ends_with(kOfPart)) without.resize(without.size() - kOfPart.size());
  return without;
}

const Command* find_command(const std::string& name) {
  for (const Command& command : commands())
    if (command.name == name) return &command;
  return nullptr;
}

const Command* find_command(int key, int mods) {
  const int relevant = mods & (GLFW_MOD_CONTROL | GLFW_MOD_SHIFT | GLFW_MOD_ALT);
  for (const Command& command : commands())
    if (command.key != 0 && command.key == key && command.mods == relevant) return &command;
  return nullptr;
}

const Command* find_in_menus(std::string_view words) {
  for (const Command& command : commands()) {
    const MenuPlace place(command);
    std::string all(place.menu);
    if (!place.submenu.empty()) all.append(", ").append(place.submenu);
    all.append(", ").append(command.title);
    if (all.ends_with("…")) all.resize(all.size() - std::string_view("…").size());
    if (!place.menu.empty() && all == words) return &command;
  }
  return nullptr;
}

std::string command_list() {
  std::string text = "Mouse and held keys:\n";
  char line[200];
  for (const Gesture& gesture : kGestures) {
    std::snprintf(line, sizeof line, "  %-31s%s\n", gesture.how, gesture.what);
    text += line;
  }
  text += "Keys, and the names of their commands in scripts:\n";
  for (const Command& command : commands()) {
    std::snprintf(line, sizeof line, "  %-13s %-16s %s\n", command.keys, command.name, command.help);
    text += line;
  }
  return text;
}

}  // namespace sightline::apps
