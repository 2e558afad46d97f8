// Signatures that inspect.signature() and editors read.
#pragma once

#include "sightline/bindings/python/convert.h"

namespace sightline::python {

/// pybind11 writes a function's arguments into its docstring, as "frame(self: Engine, view: View) -> FrameReport".
/// Puts what Python takes for a signature before it, of the same arguments, without types: "frame(self, view)". For all
/// functions, methods and constructors of the module.
void tell_signatures(const py::module_& m);

}  // namespace sightline::python
