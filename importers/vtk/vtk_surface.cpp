#include "sightline/importers/vtk/internal/vtk_surface.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkCommand.h>
#include <vtkGeometryFilter.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include "sightline/core/internal/ascii_case.h"

namespace sightline::importers {
namespace {

constexpr const char* kOriginalCells = "vtkOriginalCellIds";  // the filter leaks any other name

vtkUnsignedCharArray* as_colours(vtkAbstractArray* array) {
  auto* colours = vtkUnsignedCharArray::SafeDownCast(array);
  const int components = colours ? colours->GetNumberOfComponents() : 0;
  return components == 3 || components == 4 ? colours : nullptr;
}

/// How many points a cell has: at least `least`, and no more unless `open`. 0: cells of the type are not read.
struct CellSize {
  int least = 0;
  bool open = false;
  bool fits(vtkIdType size) const { return size == least || (open && size > least); }
};

/// By VTK's number of the type.
constexpr auto kCellSizes = [] {
  constexpr std::pair<int, CellSize> kKnown[] = {{VTK_VERTEX, {1}},
                                                 {VTK_POLY_VERTEX, {1, true}},
                                                 {VTK_LINE, {2}},
                                                 {VTK_POLY_LINE, {2, true}},
                                                 {VTK_TRIANGLE, {3}},
                                                 {VTK_TRIANGLE_STRIP, {3, true}},
                                                 {VTK_POLYGON, {3, true}},
                                                 {VTK_PIXEL, {4}},
                                                 {VTK_QUAD, {4}},
                                                 {VTK_TETRA, {4}},
                                                 {VTK_VOXEL, {8}},
                                                 {VTK_HEXAHEDRON, {8}},
                                                 {VTK_WEDGE, {6}},
                                                 {VTK_PYRAMID, {5}},
                                                 {VTK_PENTAGONAL_PRISM, {10}},
                                                 {VTK_HEXAGONAL_PRISM, {12}},
                                                 {VTK_QUADRATIC_EDGE, {3}},
                                                 {VTK_QUADRATIC_TRIANGLE, {6}},
                                                 {VTK_QUADRATIC_QUAD, {8}},
                                                 {VTK_QUADRATIC_TETRA, {10}},
                                                 {VTK_QUADRATIC_HEXAHEDRON, {20}},
                                                 {VTK_QUADRATIC_WEDGE, {15}},
                                                 {VTK_QUADRATIC_PYRAMID, {13}},
                                                 {VTK_BIQUADRATIC_QUAD, {9}},
                                                 {VTK_TRIQUADRATIC_HEXAHEDRON, {27}},
                                                 {VTK_QUADRATIC_LINEAR_QUAD, {6}},
                                                 {VTK_QUADRATIC_LINEAR_WEDGE, {12}},
                                                 {VTK_BIQUADRATIC_QUADRATIC_WEDGE, {18}},
                                                 {VTK_BIQUADRATIC_QUADRATIC_HEXAHEDRON, {24}},
                                                 {VTK_BIQUADRATIC_TRIANGLE, {7}},
                                                 {VTK_POLYHEDRON, {4, true}}};
  std::array<CellSize, VTK_NUMBER_OF_CELL_TYPES> sizes{};
  for (const auto& [type, size] : kKnown) sizes[std::size_t(type)] = size;
  return sizes;
}();

/// Checks whether VTK may work on a grid's cells.
class CellCheck {
 public:
  explicit CellCheck(vtkUnstructuredGrid& grid)
      : points_(grid.GetNumberOfPoints()), faces_(grid.GetFaces()), locations_(grid.GetFaceLocations()) {}

  /// What is wrong with the cell; empty for a good one.
  std::string fault(vtkIdType cell, int type, std::span<const vtkIdType> ids) {
    if (type == VTK_EMPTY_CELL && ids.empty()) return {};
    const CellSize size = std::size_t(type) < kCellSizes.size() ? kCellSizes[std::size_t(type)] : CellSize{};
    if (size.least == 0) return fmt::format("expected a linear, quadratic or polyhedral type, found type {}", type);
    if (!size.fits(vtkIdType(ids.size())))
      return fmt::format("expected {}{} points for a cell of type {}, found {}", size.open ? "at least " : "",
                         size.least, type, ids.size());
    for (const vtkIdType id : ids)
      if (id < 0 || id >= points_) return fmt::format("expected a point below {}, found {}", points_, id);
    if (type == VTK_POLYHEDRON && !faces_are_good(cell, ids)) return "the faces of a polyhedron are damaged";
    return {};
  }

  /// The face stream of a good polyhedron: number of faces, then each face's size and points.
  std::span<const vtkIdType> face_stream(vtkIdType cell) const {
    const vtkIdType begin = locations_->GetValue(cell);
    vtkIdType end = begin + 1;
    for (vtkIdType f = 0; f < faces_->GetValue(begin); ++f) end += 1 + faces_->GetValue(end);
    return {faces_->GetPointer(begin), std::size_t(end - begin)};
  }

 private:
  bool faces_are_good(vtkIdType cell, std::span<const vtkIdType> ids) {
    if (!faces_ || !locations_ || cell >= locations_->GetNumberOfValues()) return false;
    sorted_.assign(ids.begin(), ids.end());
    std::sort(sorted_.begin(), sorted_.end());
    const vtkIdType end = faces_->GetNumberOfValues();
    vtkIdType at = locations_->GetValue(cell);
    if (at < 0 || at >= end) return false;
    const vtkIdType faces = faces_->GetValue(at++);
    if (faces < 4) return false;
    for (vtkIdType f = 0; f < faces; ++f) {
      if (at >= end) return false;
      const vtkIdType size = faces_->GetValue(at++);
      if (size < 3 || size > end - at) return false;
      for (const vtkIdType stop = at + size; at < stop; ++at)
        if (!std::binary_search(sorted_.begin(), sorted_.end(), faces_->GetValue(at))) return false;
    }
    return true;
  }

  const vtkIdType points_;
  vtkIdTypeArray *faces_, *locations_;
  std::vector<vtkIdType> sorted_;
};

/// VTK finds the faces that cells share in lists by point: its time is the sum of the lists' lengths squared. Meshes
/// have tens of cells at a point, and here and there a hub. A file made for it has all its cells at a few points, and
/// takes hours.
bool crowded(vtkCellArray& cells, vtkIdType points) {
  constexpr double kCellsAtPoint = 200.0, kAnyway = 1e8;
  std::vector<std::uint32_t> cells_at(std::size_t(points), 0);
  const auto cell = vtk::TakeSmartPointer(cells.NewIterator());
  vtkIdType size = 0;
  const vtkIdType* ids = nullptr;
  for (cell->GoToFirstCell(); !cell->IsDoneWithTraversal(); cell->GoToNextCell()) {
    cell->GetCurrentCell(size, ids);
    for (vtkIdType i = 0; i < size; ++i)
      if (ids[i] >= 0 && ids[i] < points) ++cells_at[std::size_t(ids[i])];
  }
  double work = 0.0, uses = 0.0;
  for (const double count : cells_at) work += count * count, uses += count;
  return work > kAnyway + kCellsAtPoint * uses;
}

/// The grid itself, or a copy with its good cells alone.
core::Expected<vtkSmartPointer<vtkDataSet>> checked(vtkUnstructuredGrid& grid, ImportJob& job) {
  vtkNew<vtkUnstructuredGrid> good;  // empty so far
  vtkCellArray* cells = grid.GetCells();
  if (!cells || cells->GetNumberOfCells() == 0) return vtkSmartPointer<vtkDataSet>(good);
  const auto left_out = [&](const char* message) {
    return job.damage(0, message).map([&] { return vtkSmartPointer<vtkDataSet>(good); });
  };
  vtkUnsignedCharArray* types = grid.GetCellTypesArray();
  if (!grid.GetPoints() || !cells->IsValid() || !types || types->GetNumberOfValues() != cells->GetNumberOfCells()) {
    return left_out("cells left out: expected points, rising offsets and a type for each cell");
  }
  if (crowded(*cells, grid.GetNumberOfPoints())) {
    return left_out("cells left out: expected them around many points, found them around few");
  }
  CellCheck check(grid);
  std::vector<bool> bad(std::size_t(cells->GetNumberOfCells()));
  std::size_t bad_count = 0;
  std::string first;
  const auto cell = vtk::TakeSmartPointer(cells->NewIterator());
  vtkIdType size = 0;
  const vtkIdType* ids = nullptr;
  for (cell->GoToFirstCell(); !cell->IsDoneWithTraversal(); cell->GoToNextCell()) {
    const vtkIdType id = cell->GetCurrentCellId();
    cell->GetCurrentCell(size, ids);
    std::string fault = check.fault(id, types->GetValue(id), {ids, std::size_t(size)});
    if (fault.empty()) continue;
    bad[std::size_t(id)] = true;
    if (bad_count++ == 0) first = fmt::format("cell {}: {}", id, fault);
  }
  if (bad_count == 0) return vtkSmartPointer<vtkDataSet>(&grid);
  const auto told = job.damage(0, fmt::format("{} of {} cells left out: {}", bad_count, bad.size(), first));
  if (!told) return tl::unexpected(told.error());
  good->SetPoints(grid.GetPoints());
  good->GetPointData()->ShallowCopy(grid.GetPointData());
  good->GetCellData()->CopyAllocate(grid.GetCellData());
  for (cell->GoToFirstCell(); !cell->IsDoneWithTraversal(); cell->GoToNextCell()) {
    const vtkIdType id = cell->GetCurrentCellId();
    if (bad[std::size_t(id)]) continue;
    cell->GetCurrentCell(size, ids);
    const int type = types->GetValue(id);
    vtkIdType added = 0;
    if (type == VTK_POLYHEDRON) {
      const auto faces = check.face_stream(id);
      added = good->InsertNextCell(type, size, ids, faces[0], faces.data() + 1);
    } else {
      added = good->InsertNextCell(type, size, ids);
    }
    good->GetCellData()->CopyData(grid.GetCellData(), id, added);
  }
  return vtkSmartPointer<vtkDataSet>(good);
}

/// Keeps only what a surface needs, where it has a value for every point or cell: filters carry all arrays along,
/// unchecked.
void keep_normals_colours_ghosts(vtkDataSetAttributes& attributes, vtkIdType count) {
  vtkNew<vtkCellData> kept;  // as good as any kind of attributes
  const auto whole = [&](vtkDataArray* array) { return array && array->GetNumberOfTuples() == count; };
  if (auto* normals = attributes.GetNormals(); whole(normals)) kept->SetNormals(normals);
  if (auto* colours = colours_of(attributes); whole(colours)) kept->SetScalars(colours);
  if (auto* ghosts = attributes.GetArray(vtkDataSetAttributes::GhostArrayName()); whole(ghosts)) kept->AddArray(ghosts);
  attributes.ShallowCopy(kept);
}

/// `cells`, stably sorted by the cell that each was a face of. `begin`: the surface's index of the first of them; data
/// of cells are moved along.
vtkSmartPointer<vtkCellArray> in_order_of_cells(vtkCellArray& cells, vtkIdType begin, const vtkIdType* face_of,
                                                vtkCellData& from, vtkCellData& to) {
  std::vector<vtkIdType> order(std::size_t(cells.GetNumberOfCells()));
  std::iota(order.begin(), order.end(), vtkIdType(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](vtkIdType a, vtkIdType b) { return face_of[begin + a] < face_of[begin + b]; });
  auto sorted = vtkSmartPointer<vtkCellArray>::New();
  sorted->AllocateExact(cells.GetNumberOfCells(), cells.GetNumberOfConnectivityIds());
  vtkIdType size = 0;
  const vtkIdType* ids = nullptr;
  const auto cell = vtk::TakeSmartPointer(cells.NewIterator());
  for (const vtkIdType id : order) {
    cell->GetCellAtId(id, size, ids);
    to.CopyData(&from, begin + id, begin + sorted->InsertNextCell(size, ids));
  }
  return sorted;
}

/// VTK's filter appends the faces that each of its threads found, in the order in which the threads began: another one
/// each time. Puts them into the order of the cells they belong to.
void restore_order(vtkPolyData& surface) {
  auto* face_of = vtkIdTypeArray::SafeDownCast(surface.GetCellData()->GetArray(kOriginalCells));
  if (!face_of || std::is_sorted(face_of->Begin(), face_of->End())) return;
  const vtkIdType polygons = surface.GetNumberOfVerts() + surface.GetNumberOfLines();
  const vtkIdType strips = polygons + surface.GetNumberOfPolys();
  vtkNew<vtkCellData> sorted;
  sorted->CopyAllocate(surface.GetCellData(), surface.GetNumberOfCells());
  for (vtkIdType i = 0; i < polygons; ++i) sorted->CopyData(surface.GetCellData(), i, i);
  const auto sort = [&](vtkCellArray& cells, vtkIdType begin) {
    return in_order_of_cells(cells, begin, face_of->GetPointer(0), *surface.GetCellData(), *sorted);
  };
  surface.SetPolys(sort(*surface.GetPolys(), polygons));
  surface.SetStrips(sort(*surface.GetStrips(), strips));
  surface.GetCellData()->ShallowCopy(sorted);
}

struct Watch {
  const Share& share;
  core::Expected<void> asked;
};

void on_progress(vtkObject* caller, unsigned long, void* client, void* done) {
  auto& watch = *static_cast<Watch*>(client);
  if (watch.asked) watch.asked = watch.share.progress(*static_cast<double*>(done));
  if (!watch.asked) static_cast<vtkAlgorithm*>(caller)->SetAbortExecute(1);
}

}  // namespace

vtkUnsignedCharArray* colours_of(vtkDataSetAttributes& attributes) {
  if (auto* active = as_colours(attributes.GetScalars())) return active;
  for (int i = 0; i < attributes.GetNumberOfArrays(); ++i) {
    auto* colours = as_colours(attributes.GetAbstractArray(i));
    if (!colours || !colours->GetName()) continue;
    for (const std::string_view name : {"colors", "rgb", "rgba"})
      if (core::same_but_for_case(colours->GetName(), name)) return colours;
  }
  return nullptr;
}

core::Expected<vtkSmartPointer<vtkPolyData>> outer_surface(vtkDataSet& data, const Share& share) {
  vtkSmartPointer<vtkDataSet> input;
  input.TakeReference(data.NewInstance());
  input->ShallowCopy(&data);
  input->GetFieldData()->Initialize();
  keep_normals_colours_ghosts(*input->GetPointData(), input->GetNumberOfPoints());
  keep_normals_colours_ghosts(*input->GetCellData(), input->GetNumberOfCells());
  if (auto* grid = vtkUnstructuredGrid::SafeDownCast(input)) {
    auto good = checked(*grid, share.job);
    if (!good) return tl::unexpected(good.error());
    input = *good;
  }
  vtkNew<vtkGeometryFilter> filter;
  Watch watch{share, {}};
  vtkNew<vtkCallbackCommand> command;
  command->SetCallback(on_progress);
  command->SetClientData(&watch);
  filter->AddObserver(vtkCommand::ProgressEvent, command);
  filter->SetInputData(input);
  filter->PassThroughCellIdsOn();
  filter->Update();
  if (!watch.asked) return tl::unexpected(watch.asked.error());
  restore_order(*filter->GetOutput());
  return vtkSmartPointer<vtkPolyData>(filter->GetOutput());
}

}  // namespace sightline::importers
