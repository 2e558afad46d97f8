// Damaged and malicious VTK files: no crash, no hang, no memory beyond what the headers state, and what is imported can
// be committed. Run under -fsanitize=address,undefined this also shows that no read of ours leaves the buffer.
#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "sightline/importers/vtk/internal/vtk_reader.h"
#include "sightline/tests/importers/hostile.h"
#include "sightline/tests/importers/vtk_files.h"
#include "sightline/tests/support/effort.h"

namespace sightline::importers::vtk_hostile_test {
namespace {

core::Expected<ImportReport> read_vtk_file(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                           core::Scene& scene, core::NodeId parent, const ImportOptions& options) {
  return read_vtk(bytes, path, scene, parent, options);
}

/// The target of a file's extension, read without the module.
hostile::Target target_of(std::string_view name) {
  hostile::Target target = hostile::target_of(name.substr(name.rfind('.') + 1));
  target.read = read_vtk_file;
  return target;
}

/// True when the import succeeded.
bool survives(const std::string& content, const std::string& name, bool lenient) {
  return tests::survives(target_of(name), hostile::one_file(name, content), lenient, name);
}

std::string error_of(std::string_view content, const std::string& name) {
  core::Scene scene;
  const auto report = read_vtk(std::as_bytes(std::span(content)), name, scene, scene.root());
  return report ? "" : report.error().message;
}

/// Files as VTK writes them, in more forms than the table has seeds of (hostile_test.cpp): every length in a long run.
TEST(VtkHostile, TruncatedAndMutatedFilesOfVtk) {
  int imports = 0;
  for (const auto& [name, whole] : tests::vtk_files()) {
    const hostile::Target target = target_of(name);
    int lengths = 0, whole_ones = 0;
    for (std::size_t size = 0; size < whole.size(); size += tests::long_run() ? 1 : 13, ++lengths) {
      SCOPED_TRACE(testing::Message() << name << " truncated to " << size);
      whole_ones += tests::survives_both(target, hostile::truncated(target, whole, size), target.model());
      ASSERT_FALSE(testing::Test::HasFailure());
    }
    // A legacy file's attributes may end anywhere between two sections, appended data behind the last array.
    EXPECT_LT(whole_ones, lengths) << name << ": half of strict and lenient imports";
    const hostile::Attack attack = hostile::mutation(target, {whole});
    for (int k = 0; k < tests::repeated(500); ++k)
      imports += tests::survives_both(target, attack.make(std::size_t(k)), target.model());
    ASSERT_FALSE(testing::Test::HasFailure()) << name;
  }
  EXPECT_GT(imports, 0);
}

TEST(VtkHostile, CellsThatLieAreRefused) {
  const auto file = [](const std::string& connectivity, const std::string& offsets, const std::string& types) {
    return R"(<VTKFile type="UnstructuredGrid"><UnstructuredGrid><Piece NumberOfPoints="3" NumberOfCells="2"><Points>
      <DataArray type="Float32">0 0 0 1 0 0 0 1 0</DataArray></Points><Cells><DataArray type="Int64" Name="connectivity">)" +
           connectivity + R"(</DataArray><DataArray type="Int64" Name="offsets">)" + offsets +
           R"(</DataArray><DataArray type="Int64" Name="types">)" + types +
           "</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>";
  };
  EXPECT_EQ(error_of(file("0 1 2 2 1 0", "3 6", "5 5"), "a.vtu"), "");
  const std::string rise = "expected offsets of cells that rise from 0";
  for (const char* offsets : {"6 3", "-3 6", "3 5", "3 7", "9223372036854775807 6", "0 0"})
    EXPECT_NE(error_of(file("0 1 2 2 1 0", offsets, "5 5"), "a.vtu").find(rise), std::string::npos) << offsets;
  for (const char* types : {"5 12", "5 42", "5 70", "5 255", "5 -1", "5 261"})
    EXPECT_NE(error_of(file("0 1 2 2 1 0", "3 6", types), "a.vtu").find("1 of 2 cells left out: cell 1"),
              std::string::npos)
        << types;
  for (const char* ids : {"0 1 2 2 1 3", "0 1 2 2 1 -1", "0 1 2 2 1 4294967296"})
    EXPECT_NE(error_of(file(ids, "3 6", "5 5"), "a.vtu").find("expected a point below 3"), std::string::npos) << ids;
  EXPECT_NE(error_of(file("0 1 2 2 1 0.5", "3 6", "5 5"), "a.vtu").find("expected a number"), std::string::npos);
}

TEST(VtkHostile, NestingEntitiesAndAttributes) {
  std::string deep = "<VTKFile type=\"PolyData\">", many = "<VTKFile";
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  for (int i = 0; i < 1000; ++i) many += " a" + std::to_string(i) + "=\"\"";
  EXPECT_NE(error_of(deep, "a.vtp").find("at most 64 levels"), std::string::npos);
  EXPECT_NE(error_of(many + "/>", "a.vtp").find("at most 64 attributes"), std::string::npos);
  EXPECT_FALSE(
      survives("<!DOCTYPE a [<!ENTITY b \"bb\"><!ENTITY c \"&b;&b;\">]><VTKFile type=\"&c;\"/>", "a.vtp", true));
  for (const char* text : {"<VTKFile", "<VTKFile/>", "</VTKFile>", "<>", "< >", "<a b=c/>", "<a><b></a></b>", "<!--",
                           "<?", "<VTKFile type=\"PolyData\"/>", "<VTKFile type=\"PolyData\"><PolyData/>"})
    EXPECT_FALSE(survives(text, "a.vtp", true)) << text;
}

/// A file of one compressed array of zeros.
std::string bomb(std::size_t points) {
  vtkNew<vtkPoints> zeros;
  zeros->SetNumberOfPoints(vtkIdType(points));
  std::memset(zeros->GetVoidPointer(0), 0, points * 12);
  vtkNew<vtkPolyData> data;
  data->SetPoints(zeros);
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->SetInputData(data);
  writer->SetBlockSize(1 << 24);
  return tests::written(*writer);
}

TEST(VtkHostile, CompressionIsBounded) {
  EXPECT_TRUE(survives(bomb(10000), "a.vtp", false));
  const std::string error = error_of(bomb(10000000), "a.vtp");
  EXPECT_NE(error.find("in all in a file of"), std::string::npos) << error;
}

TEST(VtkHostile, OneArrayManyTimes) {
  // Claims add up: a thousand elements that show the same appended array cost no more than one.
  std::string file = R"(<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="0"><PointData>)";
  for (int i = 0; i < 1000; ++i)
    file += R"(<DataArray type="UInt8" NumberOfComponents="3" format="appended" offset="0"/>)";
  file += R"(</PointData></Piece></PolyData><AppendedData encoding="raw">_)";
  const std::uint32_t size = 1 << 20;
  file.append(reinterpret_cast<const char*>(&size), 4);
  file.append(size, 'x');
  EXPECT_NE(error_of(file, "a.vtp").find("in all in a file of"), std::string::npos);
}

/// Cells of one type over points whose ids fit a byte, as compact as files get.
std::string dense_grid(int type, std::size_t size, std::size_t points, std::size_t cells) {
  std::mt19937 random(5);
  std::string appended;
  const auto begin = [&](std::size_t bytes) {
    const auto header = std::uint32_t(bytes);
    const std::size_t at = appended.size();
    appended.append(reinterpret_cast<const char*>(&header), 4);
    return R"(" format="appended" offset=")" + std::to_string(at) + "\"/>";
  };
  std::string file = R"(<VTKFile type="UnstructuredGrid"><UnstructuredGrid><Piece NumberOfPoints=")" +
                     std::to_string(points) + R"(" NumberOfCells=")" + std::to_string(cells) + "\">";
  file += R"(<Points><DataArray type="Int8)" + begin(3 * points) + "</Points><Cells>";
  for (std::size_t i = 0; i < 3 * points; ++i) appended += char(random() & 0x7f);
  file += R"(<DataArray Name="connectivity" type="UInt8)" + begin(size * cells);
  for (std::size_t i = 0; i < size * cells; ++i) appended += char(random() % points);
  file += R"(<DataArray Name="offsets" type="UInt32)" + begin(4 * cells);
  for (std::size_t i = 1; i <= cells; ++i) {
    const auto end = std::uint32_t(i * size);
    appended.append(reinterpret_cast<const char*>(&end), 4);
  }
  file += R"(<DataArray Name="types" type="UInt8)" + begin(cells);
  appended.append(cells, char(type));
  return file + R"(</Cells></Piece></UnstructuredGrid><AppendedData encoding="raw">_)" + appended;
}

TEST(VtkHostile, CrowdedCellsAreRefused) {
  EXPECT_TRUE(survives(dense_grid(VTK_HEXAHEDRON, 8, 250, 1000), "a.vtu", false));
  const std::string error = error_of(dense_grid(VTK_HEXAHEDRON, 8, 250, 40000), "a.vtu");
  EXPECT_NE(error.find("found them around few"), std::string::npos) << error;
}

TEST(VtkHostile, NumbersBeyondReasonAreDropped) {
  for (const char* number : {"nan", "inf", "-1e37", "1e300", "1e999999", "-inf"}) {
    SCOPED_TRACE(number);
    const std::string file = std::string("# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 4 double\n") +
                             "0 0 0 1 0 0 0 1 0 0 0 " + number + "\nPOLYGONS 2 8\n3 0 1 2\n3 0 1 3\n";
    core::Scene scene;
    const auto report = read_vtk(std::as_bytes(std::span(file)), "a.vtk", scene, scene.root());
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->warnings.size(), 1u);
    EXPECT_EQ(scene.mesh(scene.mesh_of(core::ItemId{0})).indices.size(), 3u);
    EXPECT_TRUE(scene.commit());
  }
  EXPECT_EQ(error_of("# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 1 double\n0 1e-400 +3\n", "a.vtk"),
            "");
}

TEST(VtkHostile, AppendedArraysOfNoBytes) {
  const std::string array = R"( format="appended" offset="0"/>)";
  const std::string text = R"(<VTKFile type="PolyData" byte_order="LittleEndian"><PolyData>)"
                           R"(<Piece NumberOfPoints="0" NumberOfPolys="0"><Points>)"
                           R"(<DataArray type="Float32" NumberOfComponents="3")" +
                           array + R"(</Points><Polys><DataArray type="Int64" Name="connectivity")" + array +
                           R"(<DataArray type="Int64" Name="offsets")" + array +
                           R"(</Polys></Piece></PolyData><AppendedData encoding="raw">_)" + std::string(8, '\0') +
                           "</AppendedData></VTKFile>";
  for (const bool lenient : {false, true}) EXPECT_TRUE(survives(text, "empty.vtp", lenient));
}

TEST(VtkHostile, VtkKeepsQuiet) {
  // A compressed block that is none: VTK's decompressor would print of it.
  std::string file = tests::vtk_files().at("poly_zlib.vtp");
  const std::size_t data = file.find('_', file.find("<AppendedData"));
  for (std::size_t i = data + 19; i < data + 23; ++i) file[i] = 'x';
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  const std::string error = error_of(file, "a.vtp");
  EXPECT_EQ(testing::internal::GetCapturedStderr() + testing::internal::GetCapturedStdout(), "");
  EXPECT_NE(error.find("compressed block 0 is damaged"), std::string::npos) << error;
}

}  // namespace
}  // namespace sightline::importers::vtk_hostile_test
