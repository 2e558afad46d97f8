// Internal to the importers: the part of a VTK data set that is visible from outside.
#pragma once

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include "sightline/importers/internal/import_job.h"

class vtkDataSetAttributes;
class vtkUnsignedCharArray;

namespace sightline::importers {

/// A step's part of an import's progress.
struct Share {
  ImportJob& job;
  double begin = 0.0, length = 1.0;

  core::Expected<void> progress(double done) const { return job.progress(begin + length * done); }
  Share part(double from, double to) const { return {job, begin + length * from, length * (to - from)}; }
};

/// RGB or RGBA of each tuple (vtk_import.h says which array), or none.
vtkUnsignedCharArray* colours_of(vtkDataSetAttributes& attributes);

/// Faces that belong to only one cell, counter-clockwise from outside, in the order of the cells, with normals and
/// colours. `data` may hold anything: cells are checked before VTK, which trusts them, works on them. Fails on damage when strict, and when the
/// caller cancels.
core::Expected<vtkSmartPointer<vtkPolyData>> outer_surface(vtkDataSet& data, const Share& share);

}  // namespace sightline::importers
