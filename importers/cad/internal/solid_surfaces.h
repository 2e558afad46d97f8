// Internal to the importers: the surfaces of a solid of Open CASCADE, for analytic_solid.h.
#pragma once

#include <optional>

#include <TopoDS_Shape.hxx>

#include "sightline/importers/cad/internal/analytic_solid.h"

namespace sightline::importers {

/// Nothing where the solid has several shells, is inside out or not closed, or has a face of any other surface. Splines
/// and surfaces of revolution count as what they are within the solid's own tolerance.
std::optional<SolidSurfaces> solid_surfaces(const TopoDS_Shape& solid);

}  // namespace sightline::importers
