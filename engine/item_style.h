// How an engine shows an item otherwise than the scene says: Engine::set_override().
#pragma once

#include <optional>

#include "sightline/core/conventions.h"

namespace sightline::engine {

struct ItemStyle {
  std::optional<core::vec3> colour = {};  ///< sRGB, 0 … 1, in place of the material's
  float alpha = 1.0f;                     ///< 0 … 1, times the material's
  /// Draws a line around what the picture shows of the item.
  bool outline = false;
  /// Draws the item as a faint shell that hides nothing. Picks go through it.
  bool ghost = false;

  friend bool operator==(const ItemStyle&, const ItemStyle&) = default;
};

}  // namespace sightline::engine
