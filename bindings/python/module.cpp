#include "sightline/bindings/python/module.h"

#include "sightline/bindings/python/instances.h"
#include "sightline/bindings/python/signatures.h"

namespace sightline::python {
namespace {

PyObject* error_class = nullptr;

void translate(std::exception_ptr thrown) {  // NOLINT(performance-unnecessary-value-param): as pybind11 calls it
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const Failure& failure) {
    PyErr_SetObject(error_class, to_text(failure.what()).ptr());
  }
}

}  // namespace
}  // namespace sightline::python

PYBIND11_MODULE(_sightline, m) {
  using namespace sightline::python;
  m.attr("version") = SIGHTLINE_VERSION;
  m.doc() = "The compiled half of the package sightline.";
  error_class = PyErr_NewExceptionWithDoc(
      "sightline.Error", "What went wrong: where, what was expected and what was found. One line.", nullptr, nullptr);
  if (!error_class) throw py::error_already_set();
  m.attr("Error") = py::handle(error_class);
  py::register_exception_translator(&translate);
  guard_instance_base();
  const py::object name = m.attr("__name__");
  m.attr("__name__") = "sightline";  // what classes, functions and signatures in docstrings say that they belong to
  bind_views(m);
  bind_primitives(m);
  bind_scene(m);
  bind_images(m);
  bind_culling(m);
  bind_engine(m);
  bind_paged(m);
  guard_instances(m);
  tell_signatures(m);
  m.attr("__name__") = name;
}
