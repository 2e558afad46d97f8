#include "sightline/importers/obj/internal/obj_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

#include "sightline/importers/import.h"
#include "sightline/tests/support/places.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::importers::obj_reader_test {
namespace {

class ObjReader : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) / (std::string("sightline_obj_") + test->name()) / "models";
    std::filesystem::remove_all(folder_.parent_path());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_.parent_path()); }
  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  core::Expected<ImportReport> read(const std::string& text, bool lenient = false) {
    scene_ = core::Scene();
    return import_file(write("model.obj", text), scene_, scene_.root(), {.lenient = lenient});
  }
  double area(core::ItemId item) const {
    const core::Mesh& m = scene_.mesh(scene_.mesh_of(item));
    double sum = 0;
    for (std::size_t i = 0; i < m.indices.size(); i += 3) {
      const core::dvec3 a(m.positions[m.indices[i]]), b(m.positions[m.indices[i + 1]]),
          c(m.positions[m.indices[i + 2]]);
      sum += 0.5 * glm::length(glm::cross(b - a, c - a));
    }
    return sum;
  }
  std::filesystem::path folder_;
  core::Scene scene_;
};

TEST_F(ObjReader, GroupsMaterialsAndRelativeIndices) {
  write("paint.mtl", "newmtl red\nKd 1 0 0\nd 0.25\nnewmtl green\nKd 0 1 0\nTr 0.5\n");
  const auto report = read(
      "mtllib paint.mtl\no first\nusemtl red\nv 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\n"
      "usemtl green\nf -4 -3 -2\ng second\nvn 0 0 1\nf 1//1 2//1 3//1\n");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty()) << report->warnings[0].message;
  ASSERT_EQ(scene_.item_count(), 3u);
  EXPECT_EQ(report->items[std::size_t(core::Kind::kMesh)], 3u);
  EXPECT_EQ(scene_.name(scene_.node_of(core::ItemId{0})), "first");
  EXPECT_EQ(scene_.name(scene_.node_of(core::ItemId{2})), "second");
  EXPECT_DOUBLE_EQ(area(core::ItemId{0}), 4.0);
  EXPECT_DOUBLE_EQ(area(core::ItemId{1}), 2.0);
  const core::Material &red = scene_.material(scene_.item_material(core::ItemId{0})),
                       &green = scene_.material(scene_.item_material(core::ItemId{1}));
  EXPECT_EQ(red.colour, core::vec3(1, 0, 0));
  EXPECT_EQ(red.alpha, 0.25f);
  EXPECT_EQ(green.alpha, 0.5f);
  EXPECT_TRUE(scene_.mesh(scene_.mesh_of(core::ItemId{0})).normals.empty());
  EXPECT_EQ(scene_.mesh(scene_.mesh_of(core::ItemId{2})).normals.size(), 3u);
}

TEST_F(ObjReader, MaterialsThatWouldHideTheirFacesAreOpaque) {
  // MeshLab and others wrote "Tr 1" for what is opaque; where both stand, d counts.
  write("paint.mtl",
        "newmtl a\nTr 1\nnewmtl b\nd 0\nnewmtl c\nd -1\nnewmtl d\nTr 255\nnewmtl e\nd 1\nTr 1\nnewmtl f\nTr 1\n"
        "d 0.5\nnewmtl g\nTr 0.75\nnewmtl h\nd 0.125\nnewmtl i\nd 7\nnewmtl j\nd nan\nnewmtl k\n");
  std::string text = "mtllib paint.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (char name = 'a'; name <= 'k'; ++name) text += std::string("usemtl ") + name + "\nf 1 2 3\n";
  const auto report = read(text);
  ASSERT_TRUE(report) << report.error().message;
  const float alphas[] = {1, 1, 1, 1, 1, 0.5f, 0.25f, 0.125f, 1, 1, 1};
  ASSERT_EQ(scene_.item_count(), std::size(alphas));
  for (core::ItemId item{0}; to_index(item) < std::size(alphas); ++item) {
    const core::Material& material = scene_.material(scene_.item_material(item));
    EXPECT_EQ(material.name, std::string(1, char('a' + to_index(item))));
    EXPECT_EQ(material.alpha, alphas[to_index(item)]) << material.name;
  }
  ASSERT_EQ(report->warnings.size(), 2u);
  EXPECT_EQ(report->warnings[0].message,
            "paint.mtl: line 22: 1 values that are no numbers left out, the first 'd nan'");
  EXPECT_EQ(report->warnings[1].message,
            "line 5: 4 materials are transparent throughout (d 0 or Tr 1); shown opaque, the first 'a'");
}

TEST_F(ObjReader, ProgramsThatWriteOpacityAsTr) {
  for (const std::string writer :
       {"# Converted by Meshlab Group\n", "# wavefront obj file written by the visualization toolkit\n"}) {
    write("paint.mtl", writer + "newmtl glass\nKd 1 1 1\nTr 0.25\nnewmtl wall\nKd 1 1 1\nTr 1\n");
    const auto report =
        read("mtllib paint.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl glass\nf 1 2 3\nusemtl wall\nf 1 2 3\n");
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->warnings.empty());
    EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).alpha, 0.25f);
    EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{1})).alpha, 1.0f);
  }
}

TEST_F(ObjReader, ColoursOfFourNumbersAndVerticesFilledUpWithBlack) {
  write("paint.mtl", "newmtl red\nKd 1 0 0 0.5\n");
  const auto report =
      read("mtllib paint.mtl\nv 0 0 0 0 0 0\nv 1 0 0 0 0 0\nv 0 1 0 0 0 0\nf 1 2 3\nusemtl red\nf 1 2 3\n");
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->warnings.size(), 2u);
  EXPECT_EQ(
      report->warnings[0].message,
      "paint.mtl: line 2: 1 colours with more than three numbers, of which three count, the first 'Kd 1 0 0 0.5'");
  EXPECT_EQ(report->warnings[1].message,
            "line 7: 1 items with a material whose vertices are all black: the material alone is shown");
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).colour, core::vec3(0.0f))
      << "without a material they are black";
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{1})).colour, core::vec3(1, 0, 0));
}

TEST_F(ObjReader, ObjectsOfOneNameWithVerticesOfTheirOwn) {
  const std::string valve = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n";
  const auto items = [&](const std::string& text) {
    EXPECT_TRUE(read(text));
    return scene_.item_count();
  };
  EXPECT_EQ(items("o Ventil\n" + valve + "o Ventil\n" + valve + "o Ventil\n" + valve), 3u);
  EXPECT_EQ(scene_.node_count(), 5u);
  for (core::ItemId i{0}; to_index(i) < 3; ++i) EXPECT_EQ(scene_.path(scene_.node_of(i)), "model.obj/Ventil");
  EXPECT_EQ(items("o a\ng body\n" + valve + "o a\ng body\n" + valve + "o b\ng body\n" + valve), 3u);
  EXPECT_EQ(scene_.node_count(), 8u);
  EXPECT_EQ(items("o Ger\xe4t\n" + valve + "o Ger\xe4t\n" + valve), 2u);
  // Vertices stand before all objects: what is named again goes on.
  EXPECT_EQ(items(valve + "o a\nf 1 2 3\no b\nf 1 2 3\no a\nf 1 3 2\n"), 3u);
}

TEST_F(ObjReader, FarCoordinatesKeepTheirDigits) {
  const auto report =
      read("v 3000000.001 7000000.002 0\nv 3000000.011 7000000.002 0\nv 3000000.001 7000000.012 0\nf 1 2 3\n");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_NEAR(area(core::ItemId{0}), 0.5e-4, 1e-8);
  const core::dvec3 corner = core::transform_point(
      scene_.placement(core::ItemId{0}), core::dvec3(scene_.mesh(scene_.mesh_of(core::ItemId{0})).positions[0]));
  EXPECT_NEAR(corner.x, 3000000.001, 1e-8);
}

TEST_F(ObjReader, LargeFacesAreTriangulatedWhole) {
  std::string text, face = "f";
  for (int i = 0; i < 1000; ++i) {
    text += "v " + std::to_string(std::cos(i * 2 * std::numbers::pi / 1000)) + " " +
            std::to_string(std::sin(i * 2 * std::numbers::pi / 1000)) + " 0\n";
    face += ' ';
    face += std::to_string(i + 1);
  }
  ASSERT_TRUE(read(text + face + "\n"));
  EXPECT_NEAR(area(core::ItemId{0}), std::numbers::pi, 1e-3);
}

TEST_F(ObjReader, BadIndicesNameTheLine) {
  for (const char* face : {"f 1 2 4", "f 0 1 2", "f -4 1 2", "f 2147483647 1 2", "f 99999999999999999999 1 2",
                           "f a b c", "f /1 2 3", "f 1x 2 3", "f 1,2,3"}) {
    SCOPED_TRACE(face);
    const std::string text = std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1 2 3\n") + face + "\nf 3 2 1\n";
    const auto strict = read(text);
    ASSERT_FALSE(strict);
    EXPECT_NE(strict.error().message.find("model.obj: line 6"), std::string::npos) << strict.error().message;
    EXPECT_EQ(scene_.node_count(), 1u);
    const auto lenient = read(text, true);
    ASSERT_TRUE(lenient) << lenient.error().message;
    EXPECT_EQ(lenient->warnings.size(), 1u);
    EXPECT_DOUBLE_EQ(area(core::ItemId{0}), 1.0);
  }
}

TEST_F(ObjReader, NumbersBeyondReasonAreDropped) {
  for (const char* number : {"1e300", "-1e37", "1e999999999999", "1e-2147483648"}) {
    SCOPED_TRACE(number);
    const auto report = read(std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 ") + number + "\nf 1 2 3\nf 1 2 4\n");
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(scene_.commit());
  }
}

TEST_F(ObjReader, RealFile) {
  SIGHTLINE_NEED_DATA("meshes/rocker-arm.obj");
  const auto report = import_file(tests::data_path("meshes/rocker-arm.obj"), scene_, scene_.root());
  ASSERT_TRUE(report) << report.error().message;
  const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(core::ItemId{0}));
  std::ifstream file(tests::data_path("meshes/rocker-arm.obj"));
  std::size_t faces = 0;
  for (std::string line; std::getline(file, line);) faces += line.rfind("f ", 0) == 0;
  EXPECT_EQ(mesh.indices.size(), 3 * faces);
  EXPECT_TRUE(scene_.commit());
}

TEST_F(ObjReader, VerticesAreAPositionAndANormal) {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 1 0\nvn 1e999 0 0\n";
  const auto vertices = [&](const std::string& faces) {
    EXPECT_TRUE(read(v + faces));
    const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(core::ItemId{0}));
    return std::pair(mesh.positions.size(), mesh.normals.size());
  };
  using Sizes = std::pair<std::size_t, std::size_t>;
  EXPECT_EQ(vertices("f 1//1 2//1 3//1\nf 1//1 3//1 2//1\n"), Sizes(3, 3));
  EXPECT_EQ(vertices("f 1//1 2//1 3//1\nf 1//2 3//1 2//1\n"), Sizes(4, 4));
  EXPECT_EQ(vertices("f 1//1 2//1 3//1\nf 1//2 3 2//1\n"), Sizes(5, 5));     // a corner without
  EXPECT_EQ(vertices("f 1//1 2//1 3//1\nf 1//3 3//1 2//1\n"), Sizes(4, 4));  // a normal that is no direction
  EXPECT_EQ(vertices("f 1 2 3\nf 1 3 2\n"), Sizes(3, 0));
}

TEST_F(ObjReader, MaterialsOfSeveralFiles) {
  write("a.mtl", "newmtl red\nKd 2 -1 0.5\n");
  write("b.mtl", "newmtl green\nKd 0 1 1e999\n");
  const auto report = read(
      "mtllib a.mtl\nmtllib b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl green\nf 1 2 3\nusemtl red\nf 1 2 3\n"
      "o none\nusemtl none\nf 1 2 3\n");
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(scene_.item_count(), 3u);
  std::map<std::string, core::vec3> colours;
  for (core::ItemId i{0}; to_index(i) < 3; ++i)
    if (const core::MaterialId m = scene_.item_material(i); m.valid())
      colours[scene_.material(m).name] = scene_.material(m).colour;
  EXPECT_EQ(colours, (std::map<std::string, core::vec3>{{"green", {0.8f, 0.8f, 0.8f}}, {"red", {1, 0, 0.5f}}}));
  ASSERT_EQ(report->warnings.size(), 2u);
  EXPECT_EQ(report->warnings[0].message,
            "b.mtl: line 2: 1 values that are no numbers left out, the first 'Kd 0 1 1e999'");
  EXPECT_EQ(report->warnings[1].message, "line 11: 1 materials are in no library, the first 'none'");
}

constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST_F(ObjReader, LinesMayEndInAnyWayAndGoOn) {
  const std::string lines[] = {"\xef\xbb\xbfv 0 0 0", "v\t1 \\", "  0\t0 # here, too\\", "# c:\\models\\",
                               "v 0 1 0#1",           "",        "f  1\t 2\\",           "3 ",
                               "f 3 2 \\  ",          "1"};
  for (const std::string end : {"\n", "\r", "\r\n"}) {
    std::string text;
    for (const std::string& line : lines) text += line + end;
    for (const bool whole : {true, false}) {
      const auto report = read(whole ? text : text.substr(0, text.size() - end.size()));
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_TRUE(report->warnings.empty()) << report->warnings[0].message;
      ASSERT_EQ(scene_.item_count(), 1u);
      EXPECT_DOUBLE_EQ(area(core::ItemId{0}), 1.0);
    }
    const auto refused = read(text + "f 1 2 9" + end);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("model.obj: line 11: "), std::string::npos) << refused.error().message;
  }
}

TEST_F(ObjReader, CornersOfEveryForm) {
  const std::string head = std::string(kTriangle) + "vt 0 0\nvt nan nan\nvn 0 0 1\n";
  const auto normals = [&](const std::string& face, std::size_t warnings = 0) {
    const auto report = read(head + face + "\n");
    EXPECT_TRUE(report) << report.error().message;
    if (!report || scene_.item_count() != 1) return std::size_t(99);
    EXPECT_EQ(report->warnings.size(), warnings) << face;
    EXPECT_DOUBLE_EQ(area(core::ItemId{0}), 0.5) << face;
    return scene_.mesh(scene_.mesh_of(core::ItemId{0})).normals.size();
  };
  for (const char* none : {"f 1 2 3", "f 1/1 2/2 3/1", "f 1/1/ 2/2/ 3/1/", "f 1// 2// 3//", "f 1/ 2/ 3/", "fo 1 2 3",
                           "f +1 -2 -1", "f 1/9 2/x 3/-7", "f 1// 2 3/1/"})
    EXPECT_EQ(normals(none), 0u) << none;
  for (const char* all : {"f 1//1 2//1 3//1", "f 1/1/1 2/2/1 3/1/1", "f 1//-1 2/1/+1 3//1", "f 1//1 2 3/1/"})
    EXPECT_EQ(normals(all), 3u) << all;
  for (const char* bad : {"f 1//1 2//2 3//1", "f 1//1 2//0x 3//1", "f 1//1 2/1/-2 3//1", "f 1//1 2//1/1 3//1"})
    EXPECT_EQ(normals(bad, 1), 3u) << bad;
  EXPECT_EQ(normals("f 1//9 2//2 3", 1), 0u);
}

TEST_F(ObjReader, CornersWithoutANormalHaveTheirFacesAndOthersKeepTheirs) {
  const auto report = read(std::string(kTriangle) + "vn 1 0 0\nvn 0 0 0\nvn a b c\nf 1//1 3 2//2\nf 1//1 2//3 3//1\n");
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->warnings.size(), 1u);
  EXPECT_EQ(report->warnings[0].message,
            "line 5: 2 normals that are no direction: faces have their own there, the first '0 0 0'");
  const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(core::ItemId{0}));
  const core::vec3 own[] = {{1, 0, 0}, {0, 0, -1}, {0, 0, -1}, {1, 0, 0}, {0, 0, 1}, {1, 0, 0}};
  ASSERT_EQ(mesh.indices.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(mesh.normals[mesh.indices[i]], own[i]) << i;
}

TEST_F(ObjReader, VerticesThatAreNoNumbersTakeTheirFacesAlone) {
  for (const char* vertex : {"nan nan nan", "-nan(ind) 1.#QNAN 1.#IND", "0,5 0,25 0", "1 2", "", "inf 0 0", "1e37 0 0",
                             "0x1 0 0", "1e999999999999 0 0"}) {
    SCOPED_TRACE(vertex);
    const auto report =
        read(std::string("v 9 9 9\nv 10 9 9\nv 9 10 9\nv ") + vertex + "\nf 1 2 3\nf 1 2 4\nf 4 -1 1\n");
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_EQ(report->warnings.size(), 2u);
    EXPECT_TRUE(report->warnings[0].message.starts_with("line 4: 1 vertices that are not three numbers"));
    EXPECT_EQ(report->warnings[1].message, "line 6: 2 faces dropped: they have such vertices");
    EXPECT_DOUBLE_EQ(area(core::ItemId{0}), 0.5);
    EXPECT_EQ(scene_.mesh(scene_.mesh_of(core::ItemId{0})).positions.size(), 3u);
  }
}

TEST_F(ObjReader, SmallFacesAreDroppedAndListed) {
  const auto report = read(std::string(kTriangle) + "f 1 2\nf\nf 1 2 3\nf 2\n");
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->warnings.size(), 1u);
  EXPECT_EQ(report->warnings[0].message, "line 4: 3 faces dropped: fewer than 3 corners, the first '1 2'");
  EXPECT_DOUBLE_EQ(area(core::ItemId{0}), 0.5);
}

TEST_F(ObjReader, GroupsStayApartInTheirObjects) {
  const auto report = read(std::string(kTriangle) +
                           "o PumpA\ng body\nf 1 2 3\ng PumpA\nf 1 2 3\no PumpB\nf 1 2 3\ng body\nf 1 2 3\n"
                           "o\nf 1 2 3\ng a lone group # 1\nf 1 2 3\ng Box #2\nf 1 2 3\ng\nf 1 2 3\n");
  ASSERT_TRUE(report) << report.error().message;
  const char* paths[] = {"PumpA/body", "PumpA", "PumpB", "PumpB/body", "", "a lone group", "Box #2"};
  ASSERT_EQ(scene_.item_count(), std::size(paths));
  for (core::ItemId i{0}; to_index(i) < std::size(paths); ++i)
    EXPECT_EQ(scene_.path(scene_.node_of(i)),
              std::string("model.obj") + (*paths[to_index(i)] ? "/" : "") + paths[to_index(i)]);
  EXPECT_DOUBLE_EQ(area(core::ItemId{4}), 1.0);  // both without a name
  EXPECT_EQ(scene_.node_count(), 8u);
}

TEST_F(ObjReader, WhatIsNotReadIsCounted) {
  const auto report = read(std::string(kTriangle) + "s 1\nl 1 2\nl 2 3\np 1\nsurf 0 1 0 1 1 2 3\nwhat\n1 2 3\n");
  ASSERT_TRUE(report) << report.error().message;
  const char* messages[] = {"line 5: 2 statements of lines (l) left out", "line 7: 1 statements of points (p) left out",
                            "line 8: 1 free-form curves and surfaces or calls left out, the first 'surf'",
                            "line 9: 2 lines left out that begin with no word of the format, the first 'what'",
                            "nothing to draw: the file has no items"};
  ASSERT_EQ(report->warnings.size(), std::size(messages));
  for (std::size_t i = 0; i < std::size(messages); ++i) EXPECT_EQ(report->warnings[i].message, messages[i]);
}

TEST_F(ObjReader, MaterialNamesWithSpacesAndComments) {
  write("paint.mtl",
        "\xef\xbb\xbfnewmtl  dark red \n\tKd 1 0 0 # bright\n  newmtl Material #25\nkd 0 1 0\nnewmtl grey # light\nKd "
        "0.5\n");
  const auto report = read(std::string("usemtl dark red\n") + kTriangle +
                           "f 1 2 3\nusemtl\tMaterial #25  \nf 1 2 3\nusemtl grey\nf 1 2 3\nusemtl dark red # again\n"
                           "f 1 2 3\nmtllib paint.mtl # at the end\n");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty()) << report->warnings[0].message;
  const core::vec3 colours[] = {{1, 0, 0}, {0, 1, 0}, {0.5f, 0.5f, 0.5f}, {1, 0, 0}};
  ASSERT_EQ(scene_.item_count(), std::size(colours));
  for (core::ItemId i{0}; to_index(i) < std::size(colours); ++i)
    EXPECT_EQ(scene_.material(scene_.item_material(i)).colour, colours[to_index(i)]) << to_index(i);
}

TEST_F(ObjReader, LibrariesAreFoundAsOthersNameThem) {
  std::filesystem::create_directories(folder_ / "sub");
  write("my paint.mtl", "newmtl a\nKd 1 0 0\n");
  write("other.mtl", "newmtl b\nKd 1 0 0\n");
  write("sub/deep.mtl", "newmtl c\nKd 1 0 0\n");
  struct Row {
    const char *names, *materials, *warning;
  };
  const Row rows[] = {
      {"my paint.mtl", "a", nullptr},
      {"\"my paint.mtl\"", "a", nullptr},
      {"my paint.mtl other.mtl", "ab", nullptr},
      {"other.mtl  sub/deep.mtl", "bc", nullptr},
      {"sub\\deep.mtl", "c", nullptr},
      {".\\my%20paint.mtl other.mtl", "ab", nullptr},
      {"OTHER.MTL", "b", "line 1: material file 'OTHER.MTL' not found; 'other.mtl' is read"},
      {"SUB\\Deep.mtl", "c", "line 1: material file 'SUB\\Deep.mtl' not found; 'deep.mtl' is read"},
      {"C:\\work\\other.mtl", "b", "line 1: material file 'C:\\work\\other.mtl' not found; 'other.mtl' is read"},
      {"other.mtl none.mtl", "b", "line 1: material file 'none.mtl' not found"},
      {"no paint.mtl", "", "line 1: material file 'no paint.mtl' not found"},
      {"../other.mtl", "b", "line 1: material file '../other.mtl' not found; 'other.mtl' is read"},
      {"../outside.mtl", "", "line 1: material file '../outside.mtl' refused: it lies outside the model's directory"}};
  std::ofstream(folder_.parent_path() / "outside.mtl") << "newmtl a\nKd 1 0 0\n";
  for (const Row& row : rows) {
    SCOPED_TRACE(row.names);
    std::string text = std::string("mtllib ") + row.names + "\n" + kTriangle;
    for (const char* name = row.materials; *name; ++name) text += std::string("usemtl ") + *name + "\nf 1 2 3\n";
    const auto report = read(text + (*row.materials ? "" : "f 1 2 3\n"));
    ASSERT_TRUE(report) << report.error().message;
    const bool ends_otherwise = row.warning && std::string_view(row.warning).ends_with("' is read");
    const bool found = ends_otherwise && tests::names_ignore_case() && std::filesystem::exists(folder_ / row.names);
    std::vector<std::string> warnings;
    for (const auto& warning : report->warnings) warnings.push_back(warning.message);
    EXPECT_EQ(warnings, row.warning && !found ? std::vector<std::string>{row.warning} : std::vector<std::string>());
    EXPECT_EQ(scene_.material_slots(), std::string(row.materials).size());
  }
}

TEST_F(ObjReader, MaterialsAreNeverBlackInSilence) {
  write("paint.mtl",
        "newmtl a\nKd 1 0 0\nnewmtl b\nmap_Kd none.png\nnewmtl c\nKd 0 0 0\nmap_Kd -s 1 1 -clamp on no ne.tga\n"
        "newmtl d\nKd 0 0 0\nnewmtl e\nKd 0,5 0,5 0,5\nnewmtl f\nKd spectral blue.rfl\n");
  std::string text = std::string("mtllib paint.mtl\n") + kTriangle;
  for (const char* name : {"a", "b", "c", "d", "e", "f"}) text += std::string("usemtl ") + name + "\nf 1 2 3\n";
  const auto report = read(text);
  ASSERT_TRUE(report) << report.error().message;
  const float green[] = {0, 0.8f, 0.8f, 0, 0.8f, 0.8f};
  ASSERT_EQ(scene_.item_count(), std::size(green));
  for (core::ItemId i{0}; to_index(i) < std::size(green); ++i)
    EXPECT_EQ(scene_.material(scene_.item_material(i)).colour.y, green[to_index(i)]) << to_index(i);
  ASSERT_EQ(report->warnings.size(), 3u);
  EXPECT_EQ(report->warnings[0].message,
            "paint.mtl: line 11: 2 values that are no numbers left out, the first 'Kd 0,5 0,5 0,5'");
  EXPECT_EQ(report->warnings[1].message,
            "line 7: 2 textures that could not be read count as none, the first 'none.png' not found");
  EXPECT_EQ(report->warnings[2].message,
            "line 9: 1 materials are black (Kd 0 0 0) below a texture, which is shown alone, the first 'c'");
}

TEST_F(ObjReader, TexturesCountByTheirMean) {
  const auto known = known_extensions();
  if (std::find(known.begin(), known.end(), ".glb") == known.end()) GTEST_SKIP() << "no images in this build";
  // One pixel of the colour 255, 128, 0.
  constexpr unsigned char kPng[] = {0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
                                    0x44, 0x52, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x02, 0x00, 0x00,
                                    0x00, 0x90, 0x77, 0x53, 0xde, 0x00, 0x00, 0x00, 0x0c, 0x49, 0x44, 0x41, 0x54, 0x78,
                                    0xda, 0x63, 0xf8, 0xdf, 0xc0, 0x00, 0x00, 0x04, 0x01, 0x01, 0x80, 0xfb, 0xd7, 0xcb,
                                    0xf1, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  std::filesystem::create_directories(folder_ / "Tex");
  write("Tex/an orange.png", {reinterpret_cast<const char*>(kPng), sizeof kPng});
  write("paint.mtl",
        "newmtl a\nmap_Kd Tex/an orange.png\nnewmtl b\nKd 0 0 0\nmap_Kd -s 1 1 1 -clamp on -mm 0 1 "
        "Tex\\an%20orange.png # x\n"
        "newmtl c\nKd 0 1 1\nMAP_KD Tex/an orange.png\nnewmtl d\nmap_Kd d:\\tex\\An Orange.PNG\n");
  std::string text = std::string("mtllib paint.mtl\n") + kTriangle;
  for (const char* name : {"a", "b", "c", "d"}) text += std::string("usemtl ") + name + "\nf 1 2 3\n";
  write("An orange.png", {reinterpret_cast<const char*>(kPng), sizeof kPng});
  const auto report = read(text);
  ASSERT_TRUE(report) << report.error().message;
  const core::vec3 colours[] = {{1, 128 / 255.0f, 0}, {1, 128 / 255.0f, 0}, {0, 128 / 255.0f, 0}, {1, 128 / 255.0f, 0}};
  ASSERT_EQ(scene_.item_count(), std::size(colours));
  for (core::ItemId i{0}; to_index(i) < std::size(colours); ++i)
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(scene_.material(scene_.item_material(i)).colour[k], colours[to_index(i)][k], 1e-6f)
          << to_index(i) << ' ' << k;
  ASSERT_EQ(report->warnings.size(), 2u);
  // Where names ignore case, the folder of the path is found, too.
  const std::string found = tests::names_ignore_case() ? "an orange.png" : "An orange.png";
  EXPECT_EQ(report->warnings[0].message,
            "line 11: texture 'd:\\tex\\An Orange.PNG' not found; '" + found + "' is read");
}

TEST_F(ObjReader, ColoursOfVertices) {
  const auto colours = [&](const char* a, const char* b, const char* c, const char* more = "") {
    const auto report = read(std::string("v 0 0 0 ") + a + "\nv 1 0 0 " + b + "\nv 0 1 0 " + c + "\nf 1 2 3\n" + more);
    EXPECT_TRUE(report) << report.error().message;
    const core::MaterialId material = scene_.item_material(core::ItemId{0});
    std::string found = material.valid() ? scene_.material(material).name : "none";
    for (const ImportWarning& warning : report->warnings) found += "; " + warning.message;
    return found;
  };
  EXPECT_EQ(colours("1 0 0", "1 0 0", "1 0 0"), "#ff0000");
  EXPECT_EQ(colours("1 0 0", "0.998 0.001 0", "1 0 0"), "#ff0000");
  EXPECT_EQ(colours("1 0 0 1", "1 0 0 1", "1 0 0 1"), "#ff0000");
  EXPECT_EQ(colours("255 128 0", "255 128 0", "255 128 0"), "#ff8000");
  EXPECT_EQ(colours("", "0 0 1", ""), "#0000ff");
  EXPECT_EQ(colours("1", "1", "1"), "none");  // weights
  EXPECT_EQ(
      colours("1", "1 2", "x"),
      "none; line 2: 2 vertices with something behind their coordinates that is no colour, the first '1 0 0 1 2'");
  EXPECT_EQ(colours("1 0 0", "0 0 1", "0 1 0"),
            "#555555; line 4: 1 items whose vertices differ in colour show the mean");
  EXPECT_EQ(
      colours("1 0 0", "1 0 x", "1 0 0"),
      "#ff0000; line 2: 1 colours of vertices that are not three finite numbers left out, the first '1 0 0 1 0 x'");
  write("paint.mtl", "newmtl a\nKd 1 1 1\nnewmtl b\nKd 1 0.5 1\n");
  EXPECT_EQ(colours("1 0 0", "1 0 0", "1 0 0", "mtllib paint.mtl\nusemtl b\nf 1 2 3\n"), "#ff0000");
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{1})).colour, core::vec3(1, 0, 0));
}

TEST_F(ObjReader, NormalsBehindVerticesAreNoColours) {
  const auto report = read("v 0 0 0 0 0 -1\nv 1 0 0 0 0 1\nv 0 1 0 0 0 1\nf 1 2 3\n");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_FALSE(scene_.item_material(core::ItemId{0}).valid());
  ASSERT_EQ(report->warnings.size(), 1u);
  EXPECT_EQ(report->warnings[0].message, "numbers behind the vertices are no colours, some are below 0: left out");
}

TEST_F(ObjReader, NamesBecomeUtf8) {
  write("paint.mtl", "newmtl gr\xfcn\nKd 0 1 0\n");
  const auto report = read(std::string("mtllib paint.mtl\no B\xc3\xbchne\ng R\xfchrer\nusemtl gr\xc3\xbcn\n") +
                           kTriangle + "f 1 2 3\n\xff\xfe 1\n");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(scene_.path(scene_.node_of(core::ItemId{0})), "model.obj/B\xc3\xbchne/R\xc3\xbchrer");
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).name, "gr\xc3\xbcn");
  ASSERT_EQ(report->warnings.size(), 3u);
  EXPECT_EQ(report->warnings[0].message,
            "paint.mtl: line 1: 1 names that are not UTF-8, taken for Windows-1252, the first 'gr\xc3\xbcn'");
  EXPECT_EQ(report->warnings[1].message,
            "line 3: names are not UTF-8: taken for Windows-1252, the first as 'R\xc3\xbchrer'");
  EXPECT_NE(report->warnings[2].message.find("'\xc3\xbf\xc3\xbe'"), std::string::npos);
}

TEST_F(ObjReader, Utf16IsRecognised) {
  std::string wide = "\xff\xfe";
  for (const char c : std::string(kTriangle) + "f 1 2 3\n") wide += c, wide += '\0';
  const auto report = read(wide);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_DOUBLE_EQ(area(core::ItemId{0}), 0.5);
  EXPECT_EQ(report->warnings.size(), 1u);
}

TEST_F(ObjReader, PartsWithoutAFaceGiveNoItem) {
  ASSERT_TRUE(read("v 0 0 0\nv 1 0 0\nv 0 1 0\no good\nf 1 2 3\no bad\nf 1 2 9\n", true));
  EXPECT_EQ(scene_.item_count(), 1u);
}

}  // namespace
}  // namespace sightline::importers::obj_reader_test
