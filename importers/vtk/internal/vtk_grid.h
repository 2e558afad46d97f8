// Internal to the importers: assembles data sets from the arrays of a file.
#pragma once

#include <vector>

#include <vtkDataSet.h>
#include <vtkSmartPointer.h>
#include <vtkTypeInt64Array.h>

#include "sightline/importers/vtk/internal/vtk_file.h"

class vtkCellArray;
class vtkPoints;

namespace sightline::importers {

/// Cells with their points back to back. `offsets` are as in VTK, one more than cells and rising from 0, or as in XML
/// files, without the 0. Both are integers; there are no cells when either is missing. Throws an ImportFault when
/// they contradict each other.
vtkSmartPointer<vtkCellArray> make_cells(const VtkFile& file, std::size_t at, vtkTypeInt64Array* offsets,
                                         vtkTypeInt64Array* connectivity, bool with_zero);

/// Points of three values each.
vtkSmartPointer<vtkPoints> make_points(vtkDataArray& values);

/// XML files store the faces of polyhedra apart: `faces` back to back, with a cell's part ending at ends[cell] (-1 for
/// other cells). Without these arrays the points of a polyhedron are its face stream, as in legacy files: number of
/// faces, then each face's size and points.
struct PolyhedraFaces {
  vtkTypeInt64Array* faces = nullptr;
  vtkTypeInt64Array* ends = nullptr;
};

/// `types`: one per cell. Cells are not checked here (vtk_surface.h).
vtkSmartPointer<vtkDataSet> make_grid(const VtkFile& file, std::size_t at, vtkPoints* points, vtkCellArray& cells,
                                      vtkTypeInt64Array& types, const PolyhedraFaces& apart = {});

}  // namespace sightline::importers
