// Internal to the importers: placements of IGES files that Open CASCADE 7.6 does not take as they are.
#pragma once

#include <IGESData_IGESModel.hxx>

#include "sightline/importers/internal/import_job.h"

namespace sightline::importers {

/// Before the transfer: makes instances of subfigures with a scale (entity 408) readable, and warns of transformation
/// matrices (entity 124) that distort, which Open CASCADE leaves out.
void prepare_iges_placements(ImportJob& job, const Handle(IGESData_IGESModel) & model);

}  // namespace sightline::importers
