// The entry point of the module libsightline_vtk.so, which vtk_module.cpp looks up.
#include "sightline/importers/vtk/internal/vtk_reader.h"

#if defined(_WIN32)
#define SIGHTLINE_EXPORT __declspec(dllexport)
#else
#define SIGHTLINE_EXPORT __attribute__((visibility("default")))
#endif

// The program and its module are one build: C++ types may pass between them.
extern "C" SIGHTLINE_EXPORT decltype(&sightline::importers::read_vtk) const sightline_read_vtk;
decltype(&sightline::importers::read_vtk) const sightline_read_vtk = &sightline::importers::read_vtk;
