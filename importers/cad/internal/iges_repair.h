// Internal to the importers: the text of an IGES file in the form that Open CASCADE 7.6 reads.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "sightline/importers/internal/import_job.h"

namespace sightline::importers {

/// The text without the comments behind parameters (IGES 5.3, 2.2.4.5.3). Spline curves and surfaces (entities 126 and
/// 128) whose writer left out their parameter ranges get those of the knots; such as lack more, at which Open CASCADE
/// crashes, are left out with a warning. Strings that are not UTF-8 are decoded from Windows-1252, with a warning.
/// Nothing where no entity needs a change, or the text is not what the standard calls the fixed format.
std::optional<std::string> repaired_iges(ImportJob& job, std::string_view text);

}  // namespace sightline::importers
