#include "sightline/bindings/python/get_proc.h"

#include <optional>

namespace sightline::python {
namespace {

/// As eglGetProcAddress and its kin are declared in C.
using FindProc = gl::Proc (*)(const char* name);

FindProc function_at(const py::object& address) {
  const auto number = py::cast<std::uintptr_t>(address);
  if (number == 0) fail("get_proc: expected a function, found the address 0");
  return reinterpret_cast<FindProc>(number);  // NOLINT(performance-no-int-to-ptr): Python has addresses as numbers
}

/// The address of a pointer or function of ctypes; nothing for other objects.
std::optional<py::object> address_in_ctypes(const py::object& value) {
  const py::object modules = py::module_::import("sys").attr("modules");
  if (!modules.contains("ctypes")) return std::nullopt;
  const py::object ctypes = modules["ctypes"];
  if (!py::isinstance(value, ctypes.attr("_CFuncPtr")) && !py::isinstance(value, ctypes.attr("_Pointer")) &&
      !py::isinstance(value, ctypes.attr("c_void_p")))
    return std::nullopt;
  const py::object address = ctypes.attr("cast")(value, ctypes.attr("c_void_p")).attr("value");
  return address.is_none() ? py::object(py::int_(0)) : address;
}

/// A function of Python's, and what it has thrown.
struct Callback {
  py::object function;
  std::exception_ptr thrown;

  std::uintptr_t address_of(const char* name) const {
    const py::object found = function(name);
    if (found.is_none()) return 0;
    const auto address = address_in_ctypes(found);
    return py::cast<std::uintptr_t>(py::int_(address ? *address : found));
  }
  static gl::Proc find(const char* name, void* user) {
    auto& self = *static_cast<Callback*>(user);
    if (self.thrown) return nullptr;
    try {
      return reinterpret_cast<gl::Proc>(self.address_of(name));  // NOLINT(performance-no-int-to-ptr): the same
    } catch (...) {
      self.thrown = std::current_exception();
      return nullptr;
    }
  }
};

core::Expected<gl::Context> adopt(FindProc find) {
  const auto call = [](const char* name, void* user) { return (*static_cast<FindProc*>(user))(name); };
  return gl::Context::adopt(call, &find);
}

core::Expected<gl::Context> adopt(const py::object& function) {
  Callback callback{function, {}};
  auto made = gl::Context::adopt(&Callback::find, &callback);
  if (callback.thrown) std::rethrow_exception(callback.thrown);
  return made;
}

}  // namespace

std::unique_ptr<gl::Context> adopt_context(const py::object& get_proc) {
  const auto own = [](core::Expected<gl::Context>&& made) {
    return std::make_unique<gl::Context>(unwrap(std::move(made)));
  };
  if (const auto address = address_in_ctypes(get_proc)) return own(adopt(function_at(*address)));
  if (py::isinstance<py::int_>(get_proc) && !py::isinstance<py::bool_>(get_proc))
    return own(adopt(function_at(get_proc)));
  if (!PyCallable_Check(get_proc.ptr()))
    throw py::type_error("get_proc: expected a function or its address, found " +
                         std::string(py::str(py::type::of(get_proc).attr("__name__"))));
  return own(adopt(get_proc));
}

}  // namespace sightline::python
