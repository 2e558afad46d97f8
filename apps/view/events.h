// What the user does in a window, or a script in his place.
#pragma once

#include <string>
#include <vector>

#include "sightline/core/conventions.h"

namespace sightline::apps {

struct Event {
  enum class Type {
    kKey,     ///< key, mods, down
    kText,    ///< text: one character, UTF-8
    kButton,  ///< key: the button, mods, down, at
    kCursor,  ///< at
    kWheel,   ///< wheel: notches away from the user
    kDrop,    ///< files
    kExpose,  ///< the window must be drawn anew, maybe in another size
  };
  Type type;
  int key = 0, mods = 0;  ///< GLFW's numbers
  bool down = false;
  core::dvec2 at{0.0};  ///< pixels of the framebuffer from the upper left corner
  double wheel = 0.0;
  std::string text = {};
  std::vector<std::string> files = {};
};

}  // namespace sightline::apps
