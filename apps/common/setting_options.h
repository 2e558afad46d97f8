// Options for settings of engines: their names, values and help are those of engine/internal/settings.inc.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <type_traits>

#include "sightline/apps/common/command_line.h"
#include "sightline/engine/internal/choices.h"

namespace sightline::apps {

struct SettingWords {
  std::string option, help;
  double low, high;  ///< no range where `low` is not below `high`
};
/// An unknown name is a bug of the tool and throws.
const SettingWords& words_of_setting(const std::string& name);

/// The choices of an enumeration, or those of an optional one, by their names.
template <class T, class Enum>
std::map<std::string, T> choices_of() {
  std::map<std::string, T> all;
  for (std::size_t i = 0; i < engine::kChoices<Enum>.size(); ++i)
    all.emplace(engine::kChoices<Enum>[i], Enum(std::uint8_t(i)));
  return all;
}

/// "--min-projected-area" for "min_projected_area", into `value`.
template <class T>
Option add_setting(CommandLine line, const std::string& name, T& value) {
  const SettingWords& words = words_of_setting(name);
  if constexpr (std::is_same_v<T, bool>) {
    return line.add_choice(words.option, value, {{"on", true}, {"off", false}}, words.help).shows_default();
  } else if constexpr (std::is_enum_v<T>) {
    return line.add_choice(words.option, value, choices_of<T, T>(), words.help).shows_default();
  } else if constexpr (requires { requires std::is_enum_v<typename T::value_type>; }) {
    return line.add_choice(words.option, value, choices_of<T, typename T::value_type>(), words.help);
  } else {
    const Option option = line.add(words.option, value, words.help).shows_default();
    if (std::isinf(words.high)) return option.not_negative();
    return words.low < words.high ? option.in_range(T(words.low), T(words.high)) : option;
  }
}

}  // namespace sightline::apps
