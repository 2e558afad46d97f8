#include "sightline/bindings/python/convert.h"

#include <cstring>

namespace sightline::python {
namespace {

std::string shape_text(const py::ssize_t* lengths, std::size_t count) {
  std::string text = "(";
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) text += ", ";
    text += lengths[i] < 0 ? "N" : std::to_string(lengths[i]);
  }
  return text + (count == 1 ? ",)" : ")");
}

/// `value` as an array of `kinds` (numpy's letters) and `shape`; `what` names the kinds in the error.
py::array array_of(py::handle value, const char* argument, const Shape& shape, std::string_view kinds,
                   const char* what) {
  py::array array = value.is_none() ? py::array() : py::array::ensure(value);
  if (value.is_none() || !array) {
    PyErr_Clear();
    fail(std::string(argument) + ": expected " + what + " of shape " + shape_text(shape.data(), shape.size()) +
         ", found " + std::string(py::str(py::type::of(value).attr("__name__"))));
  }
  bool good = array.ndim() == py::ssize_t(shape.size()) && kinds.find(array.dtype().kind()) != std::string_view::npos;
  for (std::size_t i = 0; good && i < shape.size(); ++i) good = shape[i] < 0 || shape[i] == array.shape(int(i));
  if (!good)
    fail(std::string(argument) + ": expected " + what + " of shape " + shape_text(shape.data(), shape.size()) +
         ", found " + std::string(py::str(array.dtype())) + " of shape " +
         shape_text(array.shape(), std::size_t(array.ndim())));
  return array;
}

/// In C order, aligned, in the machine's byte order.
template <class T>
Numbers<T> numbers_of(const py::array& array) {
  constexpr int kFlags = py::array::c_style | py::array::forcecast | py::detail::npy_api::NPY_ARRAY_ALIGNED_;
  auto numbers = py::array_t<T, kFlags>::ensure(array);
  if (!numbers) throw py::error_already_set();
  return py::reinterpret_steal<Numbers<T>>(numbers.release());
}

}  // namespace

py::str to_text(std::string_view bytes) {
  PyObject* text = PyUnicode_DecodeUTF8(bytes.data(), py::ssize_t(bytes.size()), "surrogateescape");
  if (!text) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(text);
}

std::string to_bytes(const py::str& text) {
  const auto bytes =
      py::reinterpret_steal<py::bytes>(PyUnicode_AsEncodedString(text.ptr(), "utf-8", "surrogateescape"));
  if (!bytes) throw py::error_already_set();
  return bytes;
}

std::size_t one_of(const char* argument, const std::string& text, std::span<const std::string_view> names) {
  std::string expected;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string_view name = names[i];
    if (name == text) return i;
    expected.append(i == 0 ? "" : i + 1 == names.size() ? " or " : ", ").append(name);
  }
  fail(std::string(argument) + ": expected " + expected + ", found \"" + text + "\"");
}

Numbers<double> doubles(py::handle value, const char* argument, const Shape& shape) {
  return numbers_of<double>(array_of(value, argument, shape, "fiu", "numbers"));
}

Numbers<float> floats(py::handle value, const char* argument, const Shape& shape) {
  return numbers_of<float>(array_of(value, argument, shape, "fiu", "numbers"));
}

Numbers<std::uint32_t> indices(py::handle value, const char* argument, const Shape& shape) {
  const py::array array = array_of(value, argument, shape, "iu", "whole numbers");
  if (!py::isinstance<py::array_t<std::uint32_t>>(array)) {
    const auto wide = numbers_of<std::int64_t>(array);
    for (py::ssize_t i = 0; i < wide.size(); ++i)
      if (const std::int64_t n = wide.data()[i]; n < 0 || n > std::int64_t(UINT32_MAX))
        fail(std::string(argument) + ": expected whole numbers from 0 to 4294967295, found " + std::to_string(n));
  }
  return numbers_of<std::uint32_t>(array);
}

Numbers<std::uint8_t> bytes(py::handle value, const char* argument, const Shape& shape) {
  const py::array array = array_of(value, argument, shape, "u", "uint8");
  if (array.itemsize() != 1)
    fail(std::string(argument) + ": expected uint8, found " + std::string(py::str(array.dtype())));
  return numbers_of<std::uint8_t>(array);
}

std::vector<core::ItemId> item_ids(py::handle value, const char* argument) {
  std::vector<core::ItemId> ids;
  if (py::isinstance<py::array>(value)) {
    const auto array = indices(value, argument, {-1});
    const auto* first = reinterpret_cast<const core::ItemId*>(array.data());
    ids.assign(first, first + array.size());
    return ids;
  }
  if (!py::isinstance<py::iterable>(value))
    fail(std::string(argument) + ": expected items or their ids, found " +
         std::string(py::str(py::type::of(value).attr("__name__"))));
  for (const py::handle item : value) {
    py::detail::make_caster<core::ItemId> id;
    if (!id.load(item, true))
      fail(std::string(argument) + ": expected items or their ids, found " + std::string(py::repr(item)));
    ids.push_back(py::detail::cast_op<core::ItemId>(id));
  }
  return ids;
}

Numbers<std::uint32_t> to_array(const std::vector<core::ItemId>& items) {
  return Numbers<std::uint32_t>(Shape{py::ssize_t(items.size())}, reinterpret_cast<const std::uint32_t*>(items.data()));
}

core::dvec3 vector3(py::handle value, const char* argument) {
  const auto v = doubles(value, argument, {3});
  return {v.data()[0], v.data()[1], v.data()[2]};
}

core::dmat4 matrix(py::handle value, const char* argument) {
  const auto rows = doubles(value, argument, {4, 4});
  core::dmat4 m;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) m[column][row] = rows.at(row, column);
  return m;
}

core::Affine affine(const double* rows, const char* argument) {
  if (rows[12] != 0.0 || rows[13] != 0.0 || rows[14] != 0.0 || rows[15] != 1.0)
    fail(std::string(argument) + ": expected 0 0 0 1 as the last row of the matrix");
  core::Affine m;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) m.linear[column][row] = rows[4 * row + column];
    m.origin[row] = rows[4 * row + 3];
  }
  return m;
}

core::Affine affine(py::handle value, const char* argument) {
  return value.is_none() ? core::Affine() : affine(doubles(value, argument, {4, 4}).data(), argument);
}

Numbers<double> to_array(const core::dvec3& v) {
  return Numbers<double>(Shape{3}, &v.x);
}

Numbers<double> to_array(const core::dmat4& m) {
  Numbers<double> rows(Shape{4, 4});
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) rows.mutable_at(row, column) = m[column][row];
  return rows;
}

Numbers<double> to_array(const core::Affine& m) {
  core::dmat4 all(m.linear);
  all[3] = core::dvec4(m.origin, 1.0);
  return to_array(all);
}

py::object to_array(const core::AabbD& box) {
  if (box.empty()) return py::none();
  const double values[] = {box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z};
  return Numbers<double>(Shape{2, 3}, values);
}

}  // namespace sightline::python
