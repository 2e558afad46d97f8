// Internal to the importers: what a STEP file says beside shapes: units, annotations, properties of parts, other files.
#pragma once

#include <filesystem>

#include <STEPCAFControl_Reader.hxx>

#include "sightline/importers/cad/internal/cad_document.h"

namespace sightline::importers {

/// Before the transfer: makes the file names of an assembly's parts those of files that are there.
core::Expected<void> find_step_parts(ImportJob& job, const std::filesystem::path& path, STEPCAFControl_Reader& reader);

/// Before the transfer, which would walk over each use of a product within a use: fails where there are more than
/// kMostNodes.
core::Expected<void> check_step_uses(ImportJob& job, STEPCAFControl_Reader& reader);

/// After the transfer.
void note_step_facts(STEPCAFControl_Reader& reader, CadDocument& document);

}  // namespace sightline::importers
