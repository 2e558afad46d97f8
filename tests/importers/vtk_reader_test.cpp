// Files that VTK's own writers made, in every form they know, against what VTK's own readers make of them.
#include "sightline/importers/vtk/internal/vtk_reader.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <vtkCellData.h>
#include <vtkCompositeDataSet.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkPointData.h>
#include <vtkPolyDataReader.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGridReader.h>
#include <vtkXMLImageDataWriter.h>
#include <vtkXMLMultiBlockDataWriter.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include "sightline/importers/import.h"
#include "sightline/importers/vtk/vtk_import.h"
#include "sightline/tests/importers/scene_compare.h"
#include "sightline/tests/importers/vtk_files.h"

namespace sightline::importers::vtk_reader_test {
namespace {

core::Expected<ImportReport> read(const std::string& bytes, const std::string& name, core::Scene& scene,
                                  const ImportOptions& options = {}) {
  return read_vtk(std::as_bytes(std::span(bytes)), name, scene, scene.root(), options);
}

/// Reads the bytes with VTK's reader.
vtkSmartPointer<vtkDataObject> read_by_vtk(const std::string& bytes, const std::string& name) {
  const auto run = [&](auto reader) {
    reader->ReadFromInputStringOn();
    reader->SetInputString(bytes);
    reader->Update();
    return vtkSmartPointer<vtkDataObject>(reader->GetOutput());
  };
  if (name.ends_with(".vtp")) return run(vtkSmartPointer<vtkXMLPolyDataReader>::New());
  if (name.ends_with(".vtu")) return run(vtkSmartPointer<vtkXMLUnstructuredGridReader>::New());
  if (name.starts_with("grid")) return run(vtkSmartPointer<vtkUnstructuredGridReader>::New());
  return run(vtkSmartPointer<vtkPolyDataReader>::New());
}

TEST(VtkReader, EveryFormAsVtkReadsIt) {
  for (const auto& [name, bytes] : tests::vtk_files()) {
    SCOPED_TRACE(name);
    core::Scene ours, theirs;
    const auto report = read(bytes, name, ours);
    ASSERT_TRUE(report) << report.error().message;
    const auto twin = import_vtk(*read_by_vtk(bytes, name), name, theirs, theirs.root());
    ASSERT_TRUE(twin) << twin.error().message;
    EXPECT_EQ(tests::scene_difference(ours, ours.root(), theirs, theirs.root()), "");
    EXPECT_EQ(report->bytes, bytes.size());
    EXPECT_GT(ours.item_count(), 0u);
    EXPECT_EQ(report->warnings.size(), twin->warnings.size());
    EXPECT_TRUE(ours.commit());
  }
}

TEST(VtkReader, CountsCoordinatesAndAttributesAreVtks) {
  core::Scene scene;
  for (const auto& [name, bytes] : tests::vtk_files()) {
    SCOPED_TRACE(name);
    scene = core::Scene();
    const auto report = read(bytes, name, scene, {.metres_per_unit = 0.5});
    ASSERT_TRUE(report);
    const core::Mesh& mesh = scene.mesh(scene.mesh_of(core::ItemId{0}));
    const bool grid = name.starts_with("grid");
    EXPECT_EQ(mesh.indices.size(), 3u * (grid ? 30 : 12));
    const core::Affine world = scene.world_from_node(scene.node_of(core::ItemId{0})) * scene.placement(core::ItemId{0});
    core::AabbD box;
    for (const core::vec3& p : mesh.positions) box.grow(core::transform_point(world, core::dvec3(p)));
    const double at = 0.5 * tests::kVtkFarAway;
    EXPECT_NEAR(box.min.x, at, 1e-6);
    EXPECT_NEAR(box.max.x, at + (grid ? 5.0 : 1.0), 1e-6);
    const auto& attributes = scene.attributes(report->nodes[0]);
    ASSERT_EQ(attributes.size(), 2u);
    EXPECT_EQ(attributes[0], (std::pair<std::string, std::string>{"made by[0]", "us, 100%"}));
    EXPECT_EQ(mesh.normals.size(), mesh.positions.size());
    const core::Material& material = scene.material(scene.item_material(core::ItemId{0}));
    EXPECT_NEAR(material.colour.x, 1.0, 0.01);
    EXPECT_NEAR(material.colour.y, 0.2, 0.01);
  }
}

class VtkIndex : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) / (std::string("sightline_vtk_") + test->name()) / "models";
    std::filesystem::remove_all(folder_.parent_path());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_.parent_path()); }
  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  static std::string index(const std::string& blocks) {
    return R"(<VTKFile type="vtkMultiBlockDataSet" version="1.0"><vtkMultiBlockDataSet>)" + blocks +
           "</vtkMultiBlockDataSet></VTKFile>";
  }
  core::Expected<ImportReport> import(const std::string& text, bool lenient = false) {
    write("model.vtm", text);
    scene_ = core::Scene();
    std::ifstream file(folder_ / "model.vtm", std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    return read_vtk(std::as_bytes(std::span(bytes)), folder_ / "model.vtm", scene_, scene_.root(),
                    {.lenient = lenient});
  }
  std::filesystem::path folder_;
  core::Scene scene_;
};

TEST_F(VtkIndex, TwoLevelsByVtksWriter) {
  vtkNew<vtkMultiBlockDataSet> top, inner;
  inner->SetBlock(0, tests::vtk_cube(2.0, core::dvec3(0.0)));
  inner->GetMetaData(0u)->Set(vtkCompositeDataSet::NAME(), "cube <1>");
  inner->SetBlock(1, tests::vtk_cells());
  top->SetBlock(0, inner);
  top->GetMetaData(0u)->Set(vtkCompositeDataSet::NAME(), "inner");
  top->SetBlock(1, tests::vtk_square());
  vtkNew<vtkXMLMultiBlockDataWriter> writer;
  writer->SetInputData(top);
  writer->SetFileName((folder_ / "made.vtm").c_str());
  ASSERT_TRUE(writer->Write());
  const auto report = import_file(folder_ / "made.vtm", scene_, scene_.root());
  ASSERT_TRUE(report) << report.error().message;
  core::Scene twin;
  ASSERT_TRUE(import_vtk(*top, "made.vtm", twin, twin.root()));
  EXPECT_EQ(tests::scene_difference(scene_, scene_.root(), twin, twin.root()), "");
  EXPECT_EQ(scene_.path(scene_.node_of(core::ItemId{0})), "made.vtm/inner/cube <1>");
  EXPECT_EQ(scene_.item_count(), 3u);
}

TEST_F(VtkIndex, AFileOfSeveralBlocksIsReadOnce) {
  write("cube.vtp", tests::vtk_files().at("poly_raw.vtp"));
  const auto report =
      import(index(R"(<DataSet name="a" file="cube.vtp"/><Block name="b"><DataSet file="cube.vtp"/></Block>)"));
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(scene_.item_count(), 2u);
  EXPECT_EQ(scene_.mesh_of(core::ItemId{0}), scene_.mesh_of(core::ItemId{1}));
  EXPECT_EQ(report->shared_meshes, 1u);
}

TEST_F(VtkIndex, FilesElsewhereAndWrongOnesAreRefused) {
  const std::string cube = tests::vtk_files().at("poly_raw.vtp");
  write("cube.vtp", cube);
  write("../secret.vtp", cube);
  std::filesystem::create_symlink(folder_.parent_path() / "secret.vtp", folder_ / "link.vtp");
  write("image.vti", cube);
  write("broken.vtp", cube.substr(0, 200));
  for (const std::string& name :
       {std::string("../secret.vtp"), (folder_.parent_path() / "secret.vtp").string(), std::string("link.vtp"),
        std::string("none.vtp"), std::string("."), std::string("image.vti"), std::string("broken.vtp")}) {
    SCOPED_TRACE(name);
    const std::string text = index("<DataSet file=\"" + name + "\"/><DataSet file=\"cube.vtp\"/>");
    const auto strict = import(text);
    ASSERT_FALSE(strict);
    EXPECT_NE(strict.error().message.find(name), std::string::npos) << strict.error().message;
    EXPECT_EQ(scene_.node_count(), 1u);
    const auto lenient = import(text, true);
    ASSERT_TRUE(lenient) << lenient.error().message;
    EXPECT_EQ(lenient->warnings.size(), 1u);
    EXPECT_EQ(scene_.item_count(), 1u);
  }
}

TEST_F(VtkIndex, CyclesAndMultiplicationEnd) {
  write("other.vtm", index(R"(<DataSet file="model.vtm"/>)"));
  for (const char* block : {R"(<DataSet file="model.vtm"/>)", R"(<DataSet file="other.vtm"/>)"}) {
    const auto strict = import(index(block));
    ASSERT_FALSE(strict);
    EXPECT_NE(strict.error().message.find("names itself"), std::string::npos) << strict.error().message;
    EXPECT_TRUE(import(index(block), true));
  }
  // Each of seven files names the next one a hundred times.
  std::string many;
  for (int level = 6; level > 0; --level) {
    many.clear();
    for (int i = 0; i < 100; ++i) many += "<DataSet file=\"level" + std::to_string(level + 1) + ".vtm\"/>";
    write("level" + std::to_string(level) + ".vtm", index(many));
  }
  write("level7.vtm", index(""));
  const auto report = import(index(R"(<DataSet file="level1.vtm"/>)"), true);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("100000 blocks"), std::string::npos) << report.error().message;
  EXPECT_EQ(scene_.node_count(), 1u);
}

TEST(VtkReader, WhatHoldsNoSurfaceIsRefused) {
  core::Scene scene;
  vtkNew<vtkImageData> image;
  vtkNew<vtkXMLImageDataWriter> writer;
  writer->SetInputData(image);
  writer->WriteToOutputStringOn();
  writer->Write();
  EXPECT_FALSE(read(writer->GetOutputString(), "image.vtu", scene));
  const auto grid =
      read("# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\n", "a.vtk", scene);
  ASSERT_FALSE(grid);
  EXPECT_NE(grid.error().message.find("expected DATASET POLYDATA or UNSTRUCTURED_GRID, found 'STRUCTURED_POINTS'"),
            std::string::npos)
      << grid.error().message;
}

TEST(VtkReader, CancelLeavesTheScene) {
  for (const auto& [name, bytes] : tests::vtk_files()) {
    SCOPED_TRACE(name);
    for (int allowed = 0; allowed < 8; ++allowed) {
      core::Scene scene;
      int calls = 0;
      const auto report =
          read(bytes, name, scene, {.lenient = true, .progress = [&](double) { return calls++ < allowed; }});
      if (report) break;
      EXPECT_EQ(report.error().message, kCancelled);
      EXPECT_EQ(scene.node_count(), 1u);
      EXPECT_EQ(scene.item_slots(), 0u);
    }
  }
}

TEST(VtkReader, ProgressRises) {
  const std::string& bytes = tests::vtk_files().at("grid_zlib.vtu");
  double last = -1.0;
  core::Scene scene;
  ASSERT_TRUE(read(bytes, "grid.vtu", scene, {.progress = [&](double share) {
                     EXPECT_GT(share, last);
                     last = share;
                     return true;
                   }}));
  EXPECT_EQ(last, 1.0);
}

}  // namespace
}  // namespace sightline::importers::vtk_reader_test
