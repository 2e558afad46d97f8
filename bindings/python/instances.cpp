#include "sightline/bindings/python/instances.h"

#include <algorithm>
#include <cstring>

namespace sightline::python {
namespace {

newfunc make_instance = nullptr;  ///< pybind11's own

PyObject* make_checked(PyTypeObject* type, PyObject* arguments, PyObject* words) {
  if (py::detail::all_type_info(type).empty()) {
    PyErr_Format(PyExc_TypeError, "%s: no object can be made of this class", type->tp_name);
    return nullptr;
  }
  return make_instance(type, arguments, words);
}

/// Python compares tp_new of a class and of its bases, so all of them change: those of other modules, too.
void check_instances_of(PyTypeObject* type) {
  if (type->tp_new != make_instance) return;
  type->tp_new = &make_checked;
  for (const py::handle derived : py::handle(reinterpret_cast<PyObject*>(type)).attr("__subclasses__")())
    check_instances_of(reinterpret_cast<PyTypeObject*>(derived.ptr()));
}

/// pybind11 asks for memory where a function takes an instance that has no value yet, and then uses it as it is.
void* refuse_value(std::size_t) {
  throw py::type_error("the object was made by __new__() alone and has no value");
}

py::object reduce(const py::object& self, int protocol) {
  const py::handle object(reinterpret_cast<PyObject*>(&PyBaseObject_Type));
  return object.attr("__reduce_ex__")(self, std::max(protocol, 2));
}

/// pybind11 lets None through as `self` of a method that names no arguments, and then calls it without an object.
void require_self(py::handle method) {
  const py::handle function = py::detail::get_function(method);
  if (!function || !PyCFunction_Check(function.ptr())) return;
  PyObject* capsule = PyCFunction_GET_SELF(function.ptr());
  if (!capsule || !PyCapsule_CheckExact(capsule)) return;
  auto* overload = static_cast<py::detail::function_record*>(PyCapsule_GetPointer(capsule, PyCapsule_GetName(capsule)));
  for (; overload; overload = overload->next)
    if (overload->is_method && overload->args.empty())
      overload->args.emplace_back(strdup("self"), nullptr, py::handle(), true, false);  // which pybind11 frees
}

void guard_class(py::handle type) {
  py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(type.ptr()))->operator_new = &refuse_value;
  py::setattr(type, "__reduce_ex__",
              py::cpp_function(&reduce, py::name("__reduce_ex__"), py::is_method(type), py::arg("protocol")));
  for (const auto& [name, member] : py::dict(type.attr("__dict__"))) {
    const bool property = PyObject_TypeCheck(member.ptr(), &PyProperty_Type);
    for (const char* part : {"fget", "fset"})
      if (property) require_self(member.attr(part));
    require_self(member);
  }
}

}  // namespace

void guard_instance_base() {
  auto* base = reinterpret_cast<PyTypeObject*>(py::detail::get_internals().instance_base);
  if (base->tp_new == &make_checked) return;
  make_instance = base->tp_new;
  check_instances_of(base);
}

void guard_instances(const py::module_& m) {
  for (const auto& [name, value] : py::cast<py::dict>(m.attr("__dict__"))) {
    const bool is_class = PyType_Check(value.ptr());
    if (is_class && py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(value.ptr()))) guard_class(value);
  }
}

}  // namespace sightline::python
