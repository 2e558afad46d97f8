// A colour for each item, by the value that the model says of it.
//
// Numbers have ranges of about as many items each, from dark blue to yellow: seven places of viridis (S. van der Walt,
// N. Smith, "mpl colormaps", 2015), whose lightness rises evenly, so that it can be read without colours, too. Other
// values have the nine colours of P. Tol's scheme "muted" ("Colour Schemes", SRON/EPS/TN/09-002, 2021), which all kinds
// of colour blindness tell apart; where there are more values, the most frequent have them, and those that are left
// share a light grey.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/analysis/query/values.h"
#include "sightline/core/conventions.h"

namespace sightline::query {

struct ColourGroup {
  std::string label;  ///< a value, "LOW – HIGH" of numbers (with units of @size), "N other values" where several share
                      ///< a colour, or "no value"
  core::vec3 colour{0.0f};  ///< sRGB, 0 to 1
  std::uint32_t items = 0;  ///< at least 1
};

struct Colouring {
  std::string key;
  std::vector<ColourGroup> groups;    ///< at most 11: numbers in rising order, else the most frequent first
  std::vector<std::uint8_t> of_item;  ///< by item slot: the index of its group; 255 where there is no item
};

/// Whether values are numbers: nineteen in twenty of the items that have a value begin it with one, and they are
/// at least two. Those that are none are then "other values".
SIGHTLINE_API bool are_numbers(const Values& values);

/// Items without a value are a group of their own, white, the last one. Fails as values_of() does.
SIGHTLINE_API core::Expected<Colouring> colour_by(const core::Scene& scene, std::string_view key);

}  // namespace sightline::query
