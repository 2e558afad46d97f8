// Values between Python and C++: numpy arrays, matrices, text, errors.
//
// Python's matrices are 4 x 4 arrays for column vectors: world = matrix @ [x, y, z, 1].
#pragma once

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "sightline/core/aabb.h"
#include "sightline/core/affine.h"
#include "sightline/core/conventions.h"
#include "sightline/core/error.h"

/// Python sees ids of items as ints.
template <>
struct pybind11::detail::type_caster<sightline::core::ItemId> {
  using Number = make_caster<std::uint32_t>;
  PYBIND11_TYPE_CASTER(sightline::core::ItemId, Number::name);
  bool load(handle from, bool convert) {
    Number number;
    if (!number.load(from, convert)) return false;
    value = sightline::core::ItemId{cast_op<std::uint32_t>(number)};
    return true;
  }
  static handle cast(sightline::core::ItemId item, return_value_policy policy, handle parent) {
    return Number::cast(sightline::core::to_index(item), policy, parent);
  }
};

namespace sightline::python {

namespace py = pybind11;

/// Python sees it as sightline.Error.
class Failure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

[[noreturn]] inline void fail(const std::string& message) {
  throw Failure(message);
}

template <class T>
T unwrap(core::Expected<T>&& result) {
  if (!result) fail(result.error().message);
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// Names in files may be no UTF-8. Such bytes become lone surrogates, as in Python's file names, and come back.
py::str to_text(std::string_view bytes);
std::string to_bytes(const py::str& text);

/// Position of `text` among `names`. Fails with the names.
std::size_t one_of(const char* argument, const std::string& text, std::span<const std::string_view> names);
inline std::size_t one_of(const char* argument, const std::string& text,
                          std::initializer_list<std::string_view> names) {
  return one_of(argument, text, std::span(names.begin(), names.size()));
}

/// "(N, 3)": lengths below 0 are any.
using Shape = std::vector<py::ssize_t>;

/// The numbers of an array, or of anything that numpy makes an array of, in C order. A copy only where the type or the
/// order differs. Fails with what was expected.
template <class T>
using Numbers = py::array_t<T, py::array::c_style>;
Numbers<double> doubles(py::handle value, const char* argument, const Shape& shape);
Numbers<float> floats(py::handle value, const char* argument, const Shape& shape);
/// Whole numbers from 0 to 2^32 - 1.
Numbers<std::uint32_t> indices(py::handle value, const char* argument, const Shape& shape);
/// Bytes of an image: nothing but uint8, since other types are scaled otherwise.
Numbers<std::uint8_t> bytes(py::handle value, const char* argument, const Shape& shape);
/// Item ids: an array, or any iterable of ids and Items.
std::vector<core::ItemId> item_ids(py::handle value, const char* argument);

core::dvec3 vector3(py::handle value, const char* argument);
core::dmat4 matrix(py::handle value, const char* argument);
/// As matrix(), whose last row must be 0 0 0 1. None is the identity.
core::Affine affine(py::handle value, const char* argument);
core::Affine affine(const double* rows, const char* argument);

Numbers<std::uint32_t> to_array(const std::vector<core::ItemId>& items);
Numbers<double> to_array(const core::dvec3& v);
Numbers<double> to_array(const core::dmat4& m);
Numbers<double> to_array(const core::Affine& m);
/// [[min], [max]]; None for an empty box.
py::object to_array(const core::AabbD& box);

/// `shape` and type over memory that `owner` keeps.
template <class T>
py::array_t<T> view_of(const T* data, const Shape& shape, py::handle owner) {
  return py::array_t<T>(shape, data, owner);
}

/// An array that owns what was moved into it.
template <class T, class Owner>
py::array_t<T> take(Owner&& owner, std::vector<T> Owner::*values, const Shape& shape) {
  auto kept = std::make_unique<Owner>(std::forward<Owner>(owner));
  const T* data = ((*kept).*values).data();
  const py::capsule capsule(kept.get(), [](void* p) { delete static_cast<Owner*>(p); });
  (void)kept.release();  // the capsule has it
  return view_of(data, shape, capsule);
}

template <class T>
py::array_t<T> take(std::vector<T>&& values) {
  struct Owner {
    std::vector<T> values;
  };
  const auto size = py::ssize_t(values.size());
  return take(Owner{std::move(values)}, &Owner::values, {size});
}

/// An array of the ids' numbers, which lie in memory as the ids do.
inline py::array_t<std::uint32_t> take(std::vector<core::ItemId>&& items) {
  auto kept = std::make_unique<std::vector<core::ItemId>>(std::move(items));
  const py::ssize_t size = py::ssize_t(kept->size());
  const auto* data = reinterpret_cast<const std::uint32_t*>(kept->data());
  const py::capsule capsule(kept.get(), [](void* p) { delete static_cast<std::vector<core::ItemId>*>(p); });
  (void)kept.release();  // the capsule has it
  return view_of(data, {size}, capsule);
}

}  // namespace sightline::python
