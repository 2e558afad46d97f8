// Internal to the importers: the text of a CAD file out of what it is wrapped in.
#pragma once

#include <filesystem>
#include <string>

#include "sightline/importers/internal/import_job.h"

namespace sightline::importers {

/// The contents of a file, inflated where it is gzip, or a zip with one STEP file beside whatever else; as UTF-8 where
/// it begins with the byte order mark of UTF-16, and without the mark. At most 4 GB come out of a compressed file.
core::Expected<std::string> read_cad_text(ImportJob& job, const std::filesystem::path& path);

/// Whether a file begins like STEP, or may hold STEP that is compressed.
bool may_be_step(const std::filesystem::path& path);

}  // namespace sightline::importers
