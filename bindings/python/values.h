// Classes of plain values: equal where all their fields are, and pickled by them, which copies them, too.
#pragma once

#include <array>
#include <optional>
#include <type_traits>

#include "sightline/bindings/python/convert.h"

namespace sightline::python {

/// How many enumerators, from 0 on, an enumeration has whose fields are pickled or named.
template <class Enum>
inline constexpr int kEnumerators = 0;

/// The enumerator of that name, by name_of(). Fails with all names.
template <class Enum>
Enum enumerator_of(const char* argument, const std::string& text) {
  std::array<std::string_view, kEnumerators<Enum>> names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = name_of(Enum(i));
  return Enum(one_of(argument, text, names));
}

template <class T>
inline constexpr bool kIsOptional = false;
template <class T>
inline constexpr bool kIsOptional<std::optional<T>> = true;
template <class T>
inline constexpr bool kIsNumbers = false;
template <class T>
inline constexpr bool kIsNumbers<std::vector<T>> = std::is_arithmetic_v<T>;
template <class T>
inline constexpr bool kIsItems = std::is_same_v<T, std::vector<core::ItemId>>;

/// A field as pickles have it: enumerators as numbers, texts as bytes, lists of numbers and ids as arrays.
template <class T>
py::object stored(const T& value) {
  if constexpr (kIsOptional<T>)
    return value ? stored(*value) : py::none();
  else if constexpr (std::is_enum_v<T>)
    return py::int_(std::int64_t(value));
  else if constexpr (std::is_same_v<T, std::string>)
    return py::bytes(value);
  else if constexpr (kIsNumbers<T>)
    return py::array_t<typename T::value_type>(Shape{py::ssize_t(value.size())}, value.data());
  else if constexpr (kIsItems<T>)
    return to_array(value);
  else
    return py::cast(value);
}

/// The inverse. Throws py::cast_error where `value` is no such thing.
template <class T>
T restored(py::handle value) {
  if constexpr (kIsOptional<T>) {
    if (value.is_none()) return std::nullopt;
    return restored<typename T::value_type>(value);
  } else if constexpr (std::is_enum_v<T>) {
    static_assert(kEnumerators<T> > 0);
    const auto number = py::cast<std::int64_t>(value);
    if (number < 0 || number >= kEnumerators<T>) fail("pickle: no such value: " + std::to_string(number));
    return T(number);
  } else if constexpr (std::is_same_v<T, std::string>) {
    return py::cast<py::bytes>(value);
  } else if constexpr (kIsNumbers<T>) {
    const auto array = py::cast<py::array_t<typename T::value_type, py::array::c_style>>(value);
    return T(array.data(), array.data() + array.size());
  } else if constexpr (kIsItems<T>) {
    return item_ids(py::cast<py::array_t<std::uint32_t, py::array::c_style>>(value), "pickle");
  } else {
    return py::cast<T>(value);
  }
}

/// Gives a class its equality and its pickles. `kFields`: pointers to all of its members.
template <auto... kFields, class T>
void bind_value(py::class_<T>& c) {
  c.def(
       "__eq__", [](const T& a, const T& b) { return ((a.*kFields == b.*kFields) && ...); }, py::is_operator())
      .def(py::pickle([](const T& value) { return py::make_tuple(stored(value.*kFields)...); },
                      [](const py::tuple& state) {
                        if (state.size() != sizeof...(kFields)) fail("pickle: it is of another version");
                        T value{};
                        std::size_t i = 0;
                        ((value.*kFields = restored<std::remove_reference_t<decltype(value.*kFields)>>(state[i++])),
                         ...);
                        return value;
                      }));
}

}  // namespace sightline::python
