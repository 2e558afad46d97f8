// Instances of the module's classes where Python makes and copies them in ways that pybind11 does not expect.
#pragma once

#include "sightline/bindings/python/convert.h"

namespace sightline::python {

/// Pickles of protocols 0 and 1, and whoever looks for base classes, call pybind11's class of all instances. It throws
/// through Python's C code then, which ends the process: from now on it raises a TypeError. Classes that are bound
/// later inherit that.
void guard_instance_base();

/// For all classes of the module: pickles of protocols 0 and 1 are as those of protocol 2, or raise the same TypeError;
/// an instance that was made by __new__ alone has no value, which is a TypeError wherever it is used; and no method takes
/// None for its object.
void guard_instances(const py::module_& m);

}  // namespace sightline::python
