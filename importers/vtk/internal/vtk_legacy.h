// Internal to the importers: VTK's legacy files (.vtk), ascii and binary, versions 1 to 5.
#pragma once

#include "sightline/importers/vtk/internal/vtk_file.h"

namespace sightline::importers {

/// POLYDATA or UNSTRUCTURED_GRID with point normals, colours and strings of field data; other attributes are stepped
/// over. When lenient, damage behind the cells costs the attributes behind it and no more.
core::Expected<vtkSmartPointer<vtkDataObject>> parse_vtk_legacy(VtkFile& file);

}  // namespace sightline::importers
