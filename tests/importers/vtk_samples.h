// Small VTK objects for tests.
#pragma once

#include <array>
#include <vector>

#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include "sightline/core/aabb.h"

namespace sightline::tests {

/// A square in the plane z = at.z, facing up, its lower corner at `at`.
inline vtkSmartPointer<vtkPolyData> vtk_square(double size = 2.0, core::dvec3 at = core::dvec3(0.0)) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
    points->InsertNextPoint(at.x + x * size, at.y + y * size, at.z);
  vtkNew<vtkCellArray> polygons;
  polygons->InsertNextCell({0, 1, 2, 3});
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetPolys(polygons);
  return data;
}

/// A cube of six squares over eight points, facing outward, its lower corner at `at`.
inline vtkSmartPointer<vtkPolyData> vtk_cube(double size, core::dvec3 at) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (int i = 0; i < 8; ++i)
    points->InsertNextPoint(at.x + (i & 1) * size, at.y + (i >> 1 & 1) * size, at.z + (i >> 2) * size);
  vtkNew<vtkCellArray> polygons;
  for (const auto& face :
       {std::array<vtkIdType, 4>{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    polygons->InsertNextCell(4, face.data());
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetPolys(polygons);
  return data;
}

/// Two unit hexahedra that share a face, a tetrahedron, and a pyramid as polyhedron.
inline vtkSmartPointer<vtkUnstructuredGrid> vtk_cells(double offset = 0.0) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  for (int z = 0; z < 3; ++z)  // 0 to 11
    for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) points->InsertNextPoint(offset + x, y, z);
  for (const auto& [x, y, z] : {std::array{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}})  // 12 to 15
    points->InsertNextPoint(offset + 4 + x, y, z);
  for (const auto& [x, y, z] : {std::array{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {1, 1, 1}})  // 16 to 20
    points->InsertNextPoint(offset + 8 + x, y, z);
  grid->SetPoints(points);
  const auto hexahedron = [&](vtkIdType first) {
    std::array<vtkIdType, 8> ids{};
    for (vtkIdType i = 0; i < 8; ++i) ids[std::size_t(i)] = first + i;
    grid->InsertNextCell(VTK_HEXAHEDRON, 8, ids.data());
  };
  hexahedron(0);
  hexahedron(4);
  const std::array<vtkIdType, 4> tetrahedron{12, 13, 14, 15};
  grid->InsertNextCell(VTK_TETRA, 4, tetrahedron.data());
  const std::array<vtkIdType, 5> pyramid{16, 17, 18, 19, 20};
  const std::array<vtkIdType, 21> faces{4, 16, 19, 18, 17, 3, 16, 17, 20, 3, 17, 18, 20, 3, 18, 19, 20, 3, 19, 16, 20};
  grid->InsertNextCell(VTK_POLYHEDRON, 5, pyramid.data(), 5, faces.data());
  return grid;
}

}  // namespace sightline::tests
