// Internal to the importers: the reader of exact surfaces for import_file(). What needs Open CASCADE is in a program of
// its own, sightline-cad-reader, so that a file which makes it crash, run for ever or take all memory costs an error,
// and cancelling takes effect at once. The program hands over a scene cache.
#pragma once

#include <filesystem>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// Where the program crashes, a second one reads the shapes alone, with a warning, and a crash of that one is an error.
/// The program ends after two minutes of processor time and one more for each megabyte of the file, and at three
/// quarters of the machine's memory. With ImportOptions::in_process the module libsightline_cad.so reads instead,
/// without limits.
core::Expected<ImportReport> import_cad(const std::filesystem::path& path, core::Scene& scene, core::NodeId parent,
                                        const ImportOptions& options);

}  // namespace sightline::importers
