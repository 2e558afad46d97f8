// The entry point of the module libsightline_cad.so, which cad_import.cpp looks up.
#include "sightline/importers/cad/internal/cad_reader.h"

// The program and its module are one build: C++ types may pass between them.
extern "C" __attribute__((visibility("default"))) decltype(&sightline::importers::read_cad) const sightline_read_cad;
decltype(&sightline::importers::read_cad) const sightline_read_cad = &sightline::importers::read_cad;
