// Colours of what has changed between two revisions, in the viewer and on pages.
#pragma once

#include <optional>

#include "sightline/analysis/compare/compare.h"
#include "sightline/core/conventions.h"

namespace sightline::apps {

/// The colour (sRGB, 0 to 1) of items in a state; none where they stay faint. It is of Okabe and Ito's palette, whose
/// colours all kinds of colour blindness tell apart.
inline std::optional<core::vec3> change_colour(compare::State state) {
  switch (state) {
    case compare::State::kAdded:
      return core::vec3(0.0f, 158.0f, 115.0f) / 255.0f;
    case compare::State::kRemoved:
      return core::vec3(213.0f, 94.0f, 0.0f) / 255.0f;
    case compare::State::kMoved:
      return core::vec3(86.0f, 180.0f, 233.0f) / 255.0f;
    case compare::State::kChanged:
      return core::vec3(240.0f, 228.0f, 66.0f) / 255.0f;
    case compare::State::kUnchanged:
      break;
  }
  return std::nullopt;
}

}  // namespace sightline::apps
