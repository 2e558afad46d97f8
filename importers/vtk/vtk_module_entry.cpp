// The entry point of the module libsightline_vtk.so, which vtk_module.cpp calls.
#include "sightline/importers/vtk/internal/vtk_reader.h"

#if defined(_WIN32)
#define SIGHTLINE_EXPORT __declspec(dllexport)
#else
#define SIGHTLINE_EXPORT __attribute__((visibility("default")))
#endif

// The program and its module are one build: C++ types may pass between them.
extern "C" SIGHTLINE_EXPORT sightline::core::Expected<sightline::importers::ImportReport> sightline_read_vtk(
    std::span<const std::byte> bytes, const std::filesystem::path& path, sightline::core::Scene& scene,
    sightline::core::NodeId parent, const sightline::importers::ImportOptions& options) {
  return sightline::importers::read_vtk(bytes, path, scene, parent, options);
}
