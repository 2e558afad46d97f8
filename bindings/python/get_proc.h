// How Python hands an application's OpenGL over.
#pragma once

#include <exception>
#include <memory>

#include "sightline/bindings/python/convert.h"
#include "sightline/gl/context.h"

namespace sightline::python {

/// The context that is current on this thread, whose functions `get_proc` finds by their full names: a function of
/// Python's that takes a name and returns an address or None, a function of ctypes, or the address of a function in C
/// that does so. Needs the GIL.
std::unique_ptr<gl::Context> adopt_context(const py::object& get_proc);

}  // namespace sightline::python
