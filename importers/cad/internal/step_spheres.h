// Internal to the importers: spheres of STEP files whose faces Open CASCADE 7.6 may take for their complements.
#pragma once

#include <STEPCAFControl_Reader.hxx>

namespace sightline::importers {

/// Before the transfer. Where a spline in the border of a spherical face runs along the seam of its sphere, rounding
/// decides on which side of the seam it lies, and with that on which side of the border the face lies. Such a face gets
/// the same sphere, turned about its axis.
void turn_spheres(STEPCAFControl_Reader& reader);

}  // namespace sightline::importers
