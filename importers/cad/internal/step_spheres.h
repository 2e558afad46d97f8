// Internal to the importers: spheres of STEP files whose faces Open CASCADE 7.6 may take for their complements.
#pragma once

#include <StepShape_FaceSurface.hxx>

namespace sightline::importers {

/// Where a spline in the border of a spherical face runs along the seam of its sphere, rounding decides on which side
/// of the seam it lies, and with that on which side of the border the face lies. Such a face gets the same sphere,
/// turned about its axis. The placements of the sphere and its border must have their axes (complete_axes()).
void turn_sphere(const Handle(StepShape_FaceSurface) & face);

}  // namespace sightline::importers
