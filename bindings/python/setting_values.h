// Values of settings between C++ and Python, for code that includes the settings.inc of engines or of importers.
#pragma once

#include <filesystem>
#include <type_traits>

#include "sightline/bindings/python/values.h"
#include "sightline/engine/internal/choices.h"

namespace sightline::python {

template <class T>
inline constexpr const char* kExpected = "a text";
template <>
inline constexpr const char* kExpected<bool> = "True or False";
template <>
inline constexpr const char* kExpected<int> = "a whole number";
template <>
inline constexpr const char* kExpected<std::uint32_t> = "a whole number from 0 on";
template <>
inline constexpr const char* kExpected<std::size_t> = "a whole number from 0 on";
template <>
inline constexpr const char* kExpected<float> = "a number";
template <>
inline constexpr const char* kExpected<double> = "a number";
template <>
inline constexpr const char* kExpected<std::filesystem::path> = "a path or None";
template <>
inline constexpr const char* kExpected<std::pair<int, int>> = "two whole numbers";
template <>
inline constexpr const char* kExpected<culling::ControllerConfig> = "a ControllerConfig or None";

template <class T>
T cast(const char* name, py::handle value) {
  py::detail::make_caster<T> caster;
  if (!caster.load(value, true))
    throw py::type_error(std::string(name) + ": expected " + kExpected<T> + ", found " +
                         std::string(py::str(py::type::of(value).attr("__name__"))));
  return py::detail::cast_op<T>(std::move(caster));
}

template <class T>
inline constexpr bool kIsVector = std::is_same_v<T, core::vec3> || std::is_same_v<T, core::dvec3>;

template <class T>
py::object get(const T& value) {
  if constexpr (kIsOptional<T>)
    return value ? get(*value) : py::none();
  else if constexpr (std::is_enum_v<T>)
    return py::str(std::string(engine::kChoices<T>[std::size_t(value)]));
  else if constexpr (kIsVector<T>)
    return py::make_tuple(value.x, value.y, value.z);
  else if constexpr (std::is_same_v<T, engine::ScenePart>)
    return py::make_tuple(value.index, value.count);
  else
    return py::cast(value);
}

template <class T>
void set(T& to, const char* name, py::handle value) {
  if constexpr (kIsOptional<T>) {
    typename T::value_type given{};
    if (!value.is_none()) set(given, name, value);
    to = value.is_none() ? T() : T(given);
  } else if constexpr (std::is_enum_v<T>) {
    to = T(one_of(name, cast<std::string>(name, value), engine::kChoices<T>));
  } else if constexpr (kIsVector<T>) {
    to = T(vector3(value, name));
  } else if constexpr (std::is_same_v<T, engine::ScenePart>) {
    const auto [index, count] = cast<std::pair<int, int>>(name, value);
    to = {index, count};
  } else {
    to = cast<T>(name, value);
  }
}

/// A row of a table of settings; `member` is theirs in the struct.
#define SIGHTLINE_ROW(Config, member, name, change, range, initial, help) \
  {#name,                                                                 \
   help,                                                                  \
   range,                                                                 \
   SIGHTLINE_IS_##change,                                                 \
   std::string_view(initial).empty(),                                     \
   true,                                                                  \
   [](const Config& config) { return get(config.member); },               \
   [](Config& config, const char* argument, py::handle value) { set(config.member, argument, value); }},
#define SIGHTLINE_IS_FIXED false
#define SIGHTLINE_IS_CHANGEABLE true

}  // namespace sightline::python
