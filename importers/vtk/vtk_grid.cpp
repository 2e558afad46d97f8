#include "sightline/importers/vtk/internal/vtk_grid.h"

#include <algorithm>
#include <span>

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkCellType.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include "sightline/core/internal/sort_unique.h"

namespace sightline::importers {
namespace {

std::span<const vtkTypeInt64> values(vtkTypeInt64Array* array) {
  if (!array) return {};
  return {array->GetPointer(0), std::size_t(array->GetNumberOfValues())};
}

/// A polyhedron's points, each once, from its face stream; none when the stream does not fit `ids`.
std::vector<vtkIdType> points_of_stream(std::span<const vtkIdType> ids) {
  std::vector<vtkIdType> points;
  std::size_t at = 1;
  for (vtkIdType f = 0; !ids.empty() && f < ids[0]; ++f) {
    if (at >= ids.size() || ids[at] < 0 || std::size_t(ids[at]) > ids.size() - at - 1) return {};
    const std::size_t end = at + 1 + std::size_t(ids[at]);
    points.insert(points.end(), ids.begin() + std::ptrdiff_t(at + 1), ids.begin() + std::ptrdiff_t(end));
    at = end;
  }
  core::sort_unique(points);
  return points;
}

/// Moves the face streams of polyhedra out of the cells' points. The cells then are as VTK expects.
void take_streams(vtkSmartPointer<vtkCellArray>& cells, vtkUnsignedCharArray& types, vtkIdTypeArray& faces,
                  vtkIdTypeArray& locations) {
  vtkNew<vtkCellArray> plain;
  const auto cell = vtk::TakeSmartPointer(cells->NewIterator());
  vtkIdType size = 0;
  const vtkIdType* ids = nullptr;
  for (cell->GoToFirstCell(); !cell->IsDoneWithTraversal(); cell->GoToNextCell()) {
    cell->GetCurrentCell(size, ids);
    if (types.GetValue(cell->GetCurrentCellId()) != VTK_POLYHEDRON) {
      locations.InsertNextValue(-1);
      plain->InsertNextCell(size, ids);
      continue;
    }
    locations.InsertNextValue(faces.GetNumberOfValues());
    for (vtkIdType i = 0; i < size; ++i) faces.InsertNextValue(ids[i]);
    const std::vector<vtkIdType> points = points_of_stream({ids, std::size_t(size)});
    plain->InsertNextCell(vtkIdType(points.size()), points.data());
  }
  cells = plain;
}

}  // namespace

vtkSmartPointer<vtkCellArray> make_cells(const VtkFile& file, std::size_t at, vtkTypeInt64Array* offsets,
                                         vtkTypeInt64Array* connectivity, bool with_zero) {
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  if (values(offsets).empty()) return cells;
  vtkSmartPointer<vtkTypeInt64Array> whole = offsets;
  if (!with_zero) {
    whole = vtkSmartPointer<vtkTypeInt64Array>::New();
    whole->SetNumberOfTuples(offsets->GetNumberOfValues() + 1);
    whole->SetValue(0, 0);
    std::copy_n(offsets->GetPointer(0), offsets->GetNumberOfValues(), whole->GetPointer(1));
  }
  const auto all = values(whole);
  if (all.front() != 0 || !std::is_sorted(all.begin(), all.end()) ||
      all.back() != vtkTypeInt64(values(connectivity).size()))
    file.fail(at, fmt::format("expected offsets of cells that rise from 0 to the {} points of all cells",
                              values(connectivity).size()));
  vtkSmartPointer<vtkTypeInt64Array> points = connectivity;
  if (!points) points = vtkSmartPointer<vtkTypeInt64Array>::New();
  cells->SetData(whole, points);
  return cells;
}

vtkSmartPointer<vtkPoints> make_points(vtkDataArray& values) {
  auto points = vtkSmartPointer<vtkPoints>::New();
  values.SetNumberOfComponents(3);
  points->SetData(&values);
  return points;
}

vtkSmartPointer<vtkDataSet> make_grid(const VtkFile& file, std::size_t at, vtkPoints* points, vtkCellArray& cells,
                                      vtkTypeInt64Array& types, const PolyhedraFaces& apart) {
  const vtkIdType count = cells.GetNumberOfCells();
  if (types.GetNumberOfValues() != count)
    file.fail(at, fmt::format("expected a type for each of {} cells, found {}", count, types.GetNumberOfValues()));
  vtkNew<vtkUnsignedCharArray> small_types;
  small_types->SetNumberOfTuples(count);
  bool polyhedra = false;
  for (vtkIdType i = 0; i < count; ++i) {
    const vtkTypeInt64 type = types.GetValue(i);
    small_types->SetValue(i, type >= 0 && type < 255 ? static_cast<unsigned char>(type) : 255);  // 255: no such type
    polyhedra = polyhedra || type == VTK_POLYHEDRON;
  }
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  vtkSmartPointer<vtkCellArray> kept = &cells;
  if (!polyhedra) {
    grid->SetCells(small_types, kept);
    return grid;
  }
  vtkNew<vtkIdTypeArray> streams, locations;
  if (apart.faces && apart.ends) {
    for (const vtkTypeInt64 value : values(apart.faces)) streams->InsertNextValue(vtkIdType(value));
    vtkTypeInt64 begin = 0;
    for (const vtkTypeInt64 end : values(apart.ends)) {
      locations->InsertNextValue(end < 0 ? -1 : vtkIdType(begin));
      if (end >= 0) begin = end;
    }
    while (locations->GetNumberOfValues() < count) locations->InsertNextValue(-1);
  } else {
    take_streams(kept, *small_types, *streams, *locations);
  }
  grid->SetCells(small_types, kept, locations, streams);
  return grid;
}

}  // namespace sightline::importers
