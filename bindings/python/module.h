// python: the library for Python, as the package sightline. Translates and nothing more: numpy arrays for vectors,
// matrices, images and sets of items, keyword arguments for structs, exceptions for errors. A misuse that breaks a
// contract in C++ (a stale handle, a node of another scene) is an exception here.
#pragma once

#include "sightline/bindings/python/convert.h"

namespace sightline::python {

// In the order in which module.cpp calls them: later ones name earlier ones in their signatures.
void bind_views(py::module_& m);
void bind_primitives(py::module_& m);
void bind_scene(py::module_& m);
void bind_images(py::module_& m);
void bind_culling(py::module_& m);
void bind_engine(py::module_& m);
void bind_paged(py::module_& m);

}  // namespace sightline::python
