// Internal to the importers: VTK's legacy files (.vtk), ascii and binary, versions 1 to 5.
#pragma once

#include "sightline/importers/vtk/internal/vtk_file.h"

namespace sightline::importers {

/// Parses POLYDATA or UNSTRUCTURED_GRID with point normals, colours and strings of field data. Other attributes are
/// skipped. When lenient, damage behind the cells loses only the attributes behind it. Throws ImportFaults.
vtkSmartPointer<vtkDataObject> parse_vtk_legacy(VtkFile& file);

}  // namespace sightline::importers
