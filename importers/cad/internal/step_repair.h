// Internal to the importers: the text of a STEP file (ISO 10303-21) in the form that Open CASCADE 7.6 reads.
#pragma once

#include <string>
#include <string_view>

#include "sightline/importers/internal/import_job.h"

namespace sightline::importers {

/// The text in one pass: without comments; with one DATA section instead of several; without the sections ANCHOR,
/// REFERENCE and SIGNATURE of edition 3; and with escapes in place of characters in strings that are not ASCII. These
/// are read as UTF-8 or else Windows-1252, with a warning. Damaged text stays as damaged as it is.
std::string repaired_step(ImportJob& job, std::string_view text);

}  // namespace sightline::importers
