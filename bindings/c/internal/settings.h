// One setting in C and in C++, for code that includes the settings.inc of engines or of importers.
#pragma once

#include <filesystem>
#include <optional>
#include <type_traits>

#include "sightline/bindings/c/internal/values.h"
#include "sightline/engine/internal/choices.h"
#include "sightline/engine/internal/settings.h"

namespace sightline::capi {

/// The number of an enumerator, or 0 for none and one more for each.
template <class T>
inline constexpr bool kIsOptionalChoice = false;
template <class Enum>
inline constexpr bool kIsOptionalChoice<std::optional<Enum>> = std::is_enum_v<Enum>;

/// A setting of C in C++.
template <class From, class To>
void take(const char* name, const From& from, To& to) {
  if constexpr (std::is_same_v<To, bool>) {
    to = from != 0;
  } else if constexpr (std::is_enum_v<To>) {
    to = enum_of<To>(from, std::int32_t(engine::kChoices<To>.size()), name);
  } else if constexpr (kIsOptionalChoice<To>) {
    using Enum = typename To::value_type;
    const auto number = enum_of<std::int32_t>(from, std::int32_t(engine::kChoices<Enum>.size()) + 1, name);
    to = number > 0 ? To(Enum(number - 1)) : std::nullopt;
  } else if constexpr (std::is_pointer_v<From>) {
    to = from ? To(path_of(from)) : To();
  } else if constexpr (std::is_same_v<To, std::optional<core::vec3>>) {
    to = from.given ? To({from.colour[0], from.colour[1], from.colour[2]}) : std::nullopt;
  } else if constexpr (std::is_same_v<To, engine::ScenePart>) {
    to = {from.index, from.count};
  } else if constexpr (std::is_array_v<From>) {
    to = {from[0], from[1], from[2]};
  } else {
    to = To(from);
  }
}

/// A setting that is refused where it is a number out of range.
template <class From, class To>
void take(const engine::SettingRange& range, const From& from, To& to) {
  take(range.name, from, to);
  if (!engine::check_range(range, to))
    refuse(SL_ERROR_ARGUMENT, std::string("expected ") + range.name + " to be " + range.words);
}

/// A setting of C++ in C. Paths are left out.
template <class From, class To>
void give(const From& from, To& to) {
  if constexpr (kIsOptionalChoice<From>)
    to = from ? To(*from) + 1 : 0;
  else if constexpr (std::is_same_v<From, std::optional<core::vec3>>)
    to = from ? sl_optional_colour{1, {from->r, from->g, from->b}} : sl_optional_colour{};
  else if constexpr (std::is_same_v<From, engine::ScenePart>)
    to = {from.index, from.count};
  else if constexpr (std::is_array_v<To>)
    for (int i = 0; i < 3; ++i) to[i] = from[i];
  else if constexpr (!std::is_pointer_v<To>)
    to = To(from);
}

}  // namespace sightline::capi
