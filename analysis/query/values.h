// What a model says of its items: attributes, kinds, materials, layers, files and sizes.
//
// A key names an attribute, regardless of the case of ASCII letters. An item has the value of the nearest node, from
// its own upwards, that has the attribute; of several values there it has the first. Keys of these names are of all
// items:
//
//   @kind      core::name_of() its kind
//   @material  the name of its material, or "#rrggbb" of one without a name; items without a material have no value
//   @layer     "model", "obstruction", "insulation", or the number of the lowest layer that it lies on
//   @file      the name of the node below the root that it lies in, which an import names after its file
//   @size      the longest side of its box in the world, metres, as the shortest text that is this number
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"

namespace sightline::query {

struct Key {
  std::string name;          ///< as the first node has it
  std::uint32_t items = 0;   ///< that have a value
  std::uint32_t values = 0;  ///< different ones, of all nodes
};

/// The attributes that any item has, those of most items first, and of equally many by name. Reads every attribute
/// once: some 100 ns each. The keys with "@" are not among them.
SIGHTLINE_API std::vector<Key> attribute_keys(const core::Scene& scene);

/// The keys with "@".
SIGHTLINE_API std::span<const char* const> own_keys();

/// The values that items have for one key.
struct Values {
  struct Value {
    std::string text;
    std::uint32_t items = 0;  ///< at least 1
  };
  std::vector<Value> all;              ///< those of most items first, and of equally many by text
  std::vector<std::uint32_t> of_item;  ///< by item: the index of its value, or core::kNone
  std::uint32_t without = 0;           ///< items that have none
};

/// Fails where no item has a value for the key, with keys that are like it.
SIGHTLINE_API core::Expected<Values> values_of(const core::Scene& scene, std::string_view key);

/// The number that a value begins with, as "150" of "150 mm"; none where it begins with something else, or is not
/// finite.
SIGHTLINE_API std::optional<double> number_of(std::string_view value);

}  // namespace sightline::query
