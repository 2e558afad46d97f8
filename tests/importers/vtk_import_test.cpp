// VTK objects in memory: what becomes what, exactly where, and that VTK keeps quiet.
#include "sightline/importers/vtk/vtk_import.h"

#include <cmath>

#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkCompositeDataSet.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIdTypeArray.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkMultiPieceDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include "sightline/core/internal/srgb.h"
#include "sightline/importers/internal/face_colours.h"
#include "sightline/tests/importers/scene_compare.h"
#include "sightline/tests/importers/vtk_samples.h"

namespace sightline::importers::vtk_import_test {
namespace {

class VtkImport : public testing::Test {
 protected:
  core::Expected<ImportReport> import(vtkDataObject& data, ImportOptions options = {}) {
    scene_ = core::Scene();
    return import_vtk(data, "model", scene_, scene_.root(), options);
  }
  core::dvec3 corner(core::ItemId item, std::size_t i) const {
    const core::Affine world = scene_.world_from_node(scene_.node_of(item)) * scene_.placement(item);
    return core::transform_point(world, core::dvec3(mesh(item).positions[i]));
  }
  const core::Mesh& mesh(core::ItemId item) const { return scene_.mesh(scene_.mesh_of(item)); }
  core::Scene scene_;
};

TEST_F(VtkImport, PolygonsStripsAndNormals) {
  auto data = tests::vtk_square();
  vtkNew<vtkCellArray> strips;
  strips->InsertNextCell({0, 1, 3, 2});
  data->SetStrips(strips);
  vtkNew<vtkFloatArray> normals;
  normals->SetNumberOfComponents(3);
  for (int i = 0; i < 4; ++i) normals->InsertNextTuple3(0, 0, 1);
  data->GetPointData()->SetNormals(normals);
  const auto report = import(*data, {.metres_per_unit = 0.001});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty());
  EXPECT_EQ(report->items[std::size_t(core::Kind::kMesh)], 1u);
  ASSERT_EQ(scene_.item_count(), 1u);
  EXPECT_EQ(mesh(core::ItemId{0}).indices.size(), 12u);
  EXPECT_EQ(mesh(core::ItemId{0}).normals.size(), 4u);
  for (std::size_t t = 0; t < 12; t += 3) {  // both forms of the square face up
    const auto& m = mesh(core::ItemId{0});
    const auto a = m.positions[m.indices[t]], b = m.positions[m.indices[t + 1]], c = m.positions[m.indices[t + 2]];
    EXPECT_GT(glm::cross(b - a, c - a).z, 0.0f);
  }
  EXPECT_EQ(corner(core::ItemId{0}, 2), core::dvec3(0.002, 0.002, 0));
}

TEST_F(VtkImport, RefusesAUnitThatIsNoLength) {
  const auto report = import(*tests::vtk_square(), {.metres_per_unit = 0.0});
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, "model: metres_per_unit: expected a finite number above 0, found 0");
  EXPECT_EQ(scene_.node_count(), 1u);
}

TEST_F(VtkImport, FarPointsKeepTheirDigits) {
  const auto data = tests::vtk_square(1e-4, {1e7, -1e7, 1e7});
  ASSERT_TRUE(import(*data));
  for (vtkIdType i = 0; i < 4; ++i) {
    const double* p = data->GetPoint(i);
    const core::dvec3 got = corner(core::ItemId{0}, std::size_t(i));
    EXPECT_NEAR(got.x, p[0], 1e-8);
    EXPECT_NEAR(got.y, p[1], 1e-8);
  }
}

TEST_F(VtkImport, UpAxis) {
  const auto data = tests::vtk_square();
  ASSERT_TRUE(import(*data, {.up = UpAxis::kY}));
  EXPECT_EQ(corner(core::ItemId{0}, 2), core::dvec3(2, 0, 2));
}

TEST_F(VtkImport, SurfaceOfGridsFacesOutward) {
  const auto grid = tests::vtk_cells();
  const auto report = import(*grid);
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(scene_.item_count(), 1u);
  // Two hexahedra that share a face, a tetrahedron and a polyhedron: 10 squares, 4 triangles, 5 faces of a pyramid.
  EXPECT_EQ(mesh(core::ItemId{0}).indices.size(), 3u * (20 + 4 + 6));
  EXPECT_EQ(core::enclosure(mesh(core::ItemId{0})), core::Enclosure::kInside);
  EXPECT_TRUE(scene_.commit());
}

TEST_F(VtkImport, FacesStandInTheOrderOfTheirCellsHoweverManyThreadsFindThem) {
  // a comb of hexahedra that do not touch: every one of its 6 faces is outside, of the cell's colour
  constexpr int kCells = 5000;
  vtkNew<vtkPoints> points;
  vtkNew<vtkUnstructuredGrid> grid;
  vtkNew<vtkUnsignedCharArray> colours;
  colours->SetName("Colors");
  colours->SetNumberOfComponents(3);
  for (int i = 0; i < kCells; ++i) {
    std::array<vtkIdType, 8> ids{};
    std::size_t k = 0;
    for (int z = 0; z < 2; ++z)
      for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
        ids[k++] = points->InsertNextPoint(2 * i + x, y, z);
    grid->InsertNextCell(VTK_HEXAHEDRON, 8, ids.data());
    colours->InsertNextTuple3(i < kCells / 2 ? 255 : 0, 0, 0);
  }
  grid->SetPoints(points);
  grid->GetCellData()->SetScalars(colours);
  for (int run = 0; run < 50; ++run) {
    ASSERT_TRUE(import(*grid));
    ASSERT_EQ(scene_.item_count(), 2u);
    for (const core::ItemId item : {core::ItemId{0}, core::ItemId{1}}) {
      const bool red = scene_.material(scene_.item_material(item)).colour.x > 0.5f;
      const core::Mesh& faces = mesh(item);
      ASSERT_EQ(faces.indices.size(), std::size_t(kCells / 2 * 6 * 2 * 3));
      for (std::size_t i = 0; i < faces.indices.size(); ++i) {
        const int cell = (red ? 0 : kCells / 2) + int(i) / 36;
        ASSERT_EQ(int(corner(item, faces.indices[i]).x) / 2, cell) << "run " << run << ", corner " << i;
      }
    }
  }
}

TEST_F(VtkImport, ImagesShowTheirHull) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(3, 3, 3);
  ASSERT_TRUE(import(*image));
  EXPECT_EQ(mesh(core::ItemId{0}).indices.size(), 3u * 2 * 24);
}

TEST_F(VtkImport, ColoursOfCellsAndPoints) {
  auto data = tests::vtk_square();
  vtkNew<vtkCellArray> triangles;
  triangles->InsertNextCell({0, 1, 2});
  triangles->InsertNextCell({0, 2, 3});
  data->SetPolys(triangles);
  vtkNew<vtkUnsignedCharArray> cells, points;
  cells->SetName("colors");
  cells->SetNumberOfComponents(4);
  cells->InsertNextTuple4(255, 0, 0, 255);
  cells->InsertNextTuple4(0, 0, 255, 51);
  data->GetCellData()->AddArray(cells);
  ASSERT_TRUE(import(*data));
  ASSERT_EQ(scene_.item_count(), 2u);
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).colour, core::vec3(1, 0, 0));
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{1})).colour, core::vec3(0, 0, 1));
  EXPECT_NEAR(scene_.material(scene_.item_material(core::ItemId{1})).alpha, 0.2, 1e-6);
  EXPECT_EQ(mesh(core::ItemId{0}).positions.size(), 3u);
  EXPECT_EQ(corner(core::ItemId{1}, 1), core::dvec3(2, 2, 0));

  data->GetCellData()->Initialize();
  points->SetNumberOfComponents(3);
  for (int i = 0; i < 4; ++i) points->InsertNextTuple3(i < 2 ? 255 : 0, 51, 0);
  data->GetPointData()->SetScalars(points);
  ASSERT_TRUE(import(*data));
  ASSERT_EQ(scene_.item_count(), 2u);  // two of three corners are red, and one of three
  for (core::ItemId item{0}; to_index(item) < 2; ++item) {
    const core::vec3 mean = scene_.material(scene_.item_material(item)).colour;
    EXPECT_NEAR(mean.x, core::srgb_from_linear(to_index(item) == 0 ? 2.0 / 3.0 : 1.0 / 3.0), 0.003);
    EXPECT_NEAR(mean.y, 0.2, 0.003);
  }
}

TEST_F(VtkImport, TooManyColoursAreAveraged) {
  for (const std::size_t count : {kMostFaceColours, kMostFaceColours + 1}) {
    vtkNew<vtkPolyData> data;
    vtkNew<vtkCellArray> triangles;
    vtkNew<vtkUnsignedCharArray> colours;
    colours->SetNumberOfComponents(3);
    for (std::size_t i = 0; i < count; ++i) {
      triangles->InsertNextCell({0, 1, 2});
      colours->InsertNextTuple3(double(i % 256), double(i / 256), 0);
    }
    data->SetPoints(tests::vtk_square()->GetPoints());
    data->SetPolys(triangles);
    data->GetCellData()->SetScalars(colours);
    ASSERT_TRUE(import(*data));
    EXPECT_EQ(scene_.item_count(), count == kMostFaceColours ? count : 1u);
  }
}

TEST_F(VtkImport, BlocksAreNodesAndShareMeshes) {
  const auto square = tests::vtk_square();
  vtkNew<vtkStringArray> maker;
  maker->SetName("maker");
  maker->InsertNextValue("us");
  square->GetFieldData()->AddArray(maker);
  vtkNew<vtkMultiBlockDataSet> top, inner;
  vtkNew<vtkMultiPieceDataSet> pieces;
  inner->SetBlock(0, square);
  inner->GetMetaData(0u)->Set(vtkCompositeDataSet::NAME(), "first");
  inner->SetBlock(1, nullptr);
  inner->SetBlock(2, square);
  pieces->SetPiece(0, square);
  pieces->SetPiece(1, tests::vtk_cube(3.0, core::dvec3(0.0)));
  top->SetBlock(0, inner);
  top->GetMetaData(0u)->Set(vtkCompositeDataSet::NAME(), "inner");
  top->SetBlock(1, pieces);
  const auto report = import(*top);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(scene_.item_count(), 4u);
  EXPECT_EQ(report->shared_meshes, 2u);
  EXPECT_EQ(scene_.path(scene_.node_of(core::ItemId{0})), "model/inner/first");
  EXPECT_EQ(scene_.attributes(scene_.node_of(core::ItemId{0})), (core::Scene::Attributes{{"maker", "us"}}));
  EXPECT_EQ(scene_.mesh_of(core::ItemId{0}), scene_.mesh_of(core::ItemId{1}));
  EXPECT_EQ(scene_.node_of(core::ItemId{2}), scene_.node_of(core::ItemId{3}));
  EXPECT_EQ(square->GetReferenceCount(), 4);
}

TEST_F(VtkImport, WhatIsLeftOutIsSaid) {
  const auto data = tests::vtk_square();
  vtkNew<vtkCellArray> lines;
  lines->InsertNextCell({0, 1});
  data->SetLines(lines);
  const auto report = import(*data);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->warnings.size(), 1u);
  vtkNew<vtkTable> table;
  const auto none = import(*table);
  ASSERT_TRUE(none);
  EXPECT_EQ(none->warnings.size(), 2u) << "and nothing to draw";
  vtkNew<vtkUnstructuredGrid> empty;
  EXPECT_TRUE(import(*empty));
  vtkNew<vtkPolyData> nothing;
  EXPECT_TRUE(import(*nothing));
}

TEST_F(VtkImport, DamagedCellsNeverReachVtk) {
  struct Case {
    int type;
    std::vector<vtkIdType> ids;
  };
  const Case cases[] = {
      {VTK_HEXAHEDRON, {0, 1, 2, 3, 4, 5, 6, 99}},         {VTK_HEXAHEDRON, {0, 1, 2}},    {VTK_TETRA, {0, 1, 2, -1}},
      {VTK_LAGRANGE_HEXAHEDRON, {0, 1, 2, 3, 4, 5, 6, 7}}, {VTK_POLYHEDRON, {0, 1, 2, 3}}, {255, {0, 1, 2}}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.type);
    const auto grid = tests::vtk_cells();
    vtkNew<vtkCellArray> cells;
    vtkNew<vtkUnsignedCharArray> types;
    cells->DeepCopy(grid->GetCells());
    types->DeepCopy(grid->GetCellTypesArray());
    cells->InsertNextCell(vtkIdType(c.ids.size()), c.ids.data());
    types->InsertNextValue(static_cast<unsigned char>(c.type));
    vtkNew<vtkIdTypeArray> locations;
    locations->DeepCopy(grid->GetFaceLocations());
    locations->InsertNextValue(1);  // in the middle of another's stream
    vtkNew<vtkUnstructuredGrid> bad;
    bad->SetPoints(grid->GetPoints());
    bad->SetCells(types, cells, locations, grid->GetFaces());
    const auto strict = import(*bad);
    ASSERT_FALSE(strict);
    EXPECT_NE(strict.error().message.find("cell 4"), std::string::npos) << strict.error().message;
    EXPECT_EQ(scene_.node_count(), 1u);
    const auto lenient = import(*bad, {.lenient = true});
    ASSERT_TRUE(lenient) << lenient.error().message;
    EXPECT_EQ(mesh(core::ItemId{0}).indices.size(), 3u * (20 + 4 + 6));
  }
}

TEST_F(VtkImport, CancelLeavesTheScene) {
  const auto grid = tests::vtk_cells();
  scene_ = core::Scene();
  int calls = 0;
  const auto report =
      import_vtk(*grid, "model", scene_, scene_.root(), {.progress = [&](double) { return ++calls < 2; }});
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, kCancelled);
  EXPECT_EQ(scene_.node_count(), 1u);
  EXPECT_EQ(scene_.item_slots(), 0u);
}

TEST_F(VtkImport, AttributesOfOtherLengthAreLeftOut) {
  const auto grid = tests::vtk_cells();
  vtkNew<vtkUnsignedCharArray> colours;
  colours->SetNumberOfComponents(3);
  colours->SetNumberOfTuples(1);
  grid->GetCellData()->SetScalars(colours);
  ASSERT_TRUE(import(*grid));
  EXPECT_EQ(scene_.material_slots(), 0u);
}

}  // namespace
}  // namespace sightline::importers::vtk_import_test
