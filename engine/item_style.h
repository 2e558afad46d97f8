// How an engine shows an item otherwise than the scene says: Engine::set_override().
#pragma once

#include <optional>

#include "sightline/core/conventions.h"

namespace sightline::engine {

struct ItemStyle {
  std::optional<core::vec3> colour = {};  ///< sRGB, 0 … 1, in place of the material's
  float alpha = 1.0f;                     ///< 0 … 1, times the material's
  /// Draws a line around the item, fainter where others hide it, in EngineConfig::drawing.outline_colour. Outlined
  /// items that touch in the image have one line around them.
  bool outline = false;
  /// Draws the item as a faint shell, of which only the surface nearest to the eye shows, over an image without it. It
  /// hides nothing, and picks go through it. Sections cut it as others.
  bool ghost = false;

  friend bool operator==(const ItemStyle&, const ItemStyle&) = default;
};

/// Whether a pick may find a ghost.
enum class Ghosts { kPassed, kHit };

}  // namespace sightline::engine
