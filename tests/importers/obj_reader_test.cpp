#include "sightline/importers/obj/internal/obj_reader.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include <gtest/gtest.h>

#include "sightline/importers/import.h"
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
  EXPECT_EQ(scene_.name(scene_.node_of(0)), "first");
  EXPECT_EQ(scene_.name(scene_.node_of(2)), "second");
  EXPECT_DOUBLE_EQ(area(0), 4.0);
  EXPECT_DOUBLE_EQ(area(1), 2.0);
  const core::Material &red = scene_.material(scene_.item_material(0)),
                       &green = scene_.material(scene_.item_material(1));
  EXPECT_EQ(red.colour, core::vec3(1, 0, 0));
  EXPECT_EQ(red.alpha, 0.25f);
  EXPECT_EQ(green.alpha, 0.5f);
  EXPECT_TRUE(scene_.mesh(scene_.mesh_of(0)).normals.empty());
  EXPECT_EQ(scene_.mesh(scene_.mesh_of(2)).normals.size(), 3u);
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
  for (core::ItemId item = 0; item < std::size(alphas); ++item) {
    const core::Material& material = scene_.material(scene_.item_material(item));
    EXPECT_EQ(material.name, std::string(1, char('a' + item)));
    EXPECT_EQ(material.alpha, alphas[item]) << material.name;
  }
  ASSERT_EQ(report->warnings.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i)  // the library takes "nan" for 0
    EXPECT_EQ(report->warnings[i].message,
              std::string("material '") + "abcdj"[i] + "': transparent throughout (d 0 or Tr 1); shown opaque");
}

TEST_F(ObjReader, FarCoordinatesKeepTheirDigits) {
  const auto report =
      read("v 3000000.001 7000000.002 0\nv 3000000.011 7000000.002 0\nv 3000000.001 7000000.012 0\nf 1 2 3\n");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_NEAR(area(0), 0.5e-4, 1e-8);
  const core::dvec3 corner =
      core::transform_point(scene_.placement(0), core::dvec3(scene_.mesh(scene_.mesh_of(0)).positions[0]));
  EXPECT_NEAR(corner.x, 3000000.001, 1e-8);
}

TEST_F(ObjReader, LargeFacesAreTriangulatedWhole) {
  std::string text, face = "f";
  for (int i = 0; i < 1000; ++i) {
    text += "v " + std::to_string(std::cos(i * 2 * M_PI / 1000)) + " " + std::to_string(std::sin(i * 2 * M_PI / 1000)) +
            " 0\n";
    face += ' ';
    face += std::to_string(i + 1);
  }
  ASSERT_TRUE(read(text + face + "\n"));
  EXPECT_NEAR(area(0), M_PI, 1e-3);
}

TEST_F(ObjReader, BadIndicesNameTheLine) {
  for (const char* face :
       {"f 1 2 4", "f 0 1 2", "f -4 1 2", "f 1//2 2//1 3//1", "f 1 2", "f 2147483647 1 2", "f a b c"}) {
    SCOPED_TRACE(face);
    const std::string text = std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1 2 3\n") + face + "\nf 3 2 1\n";
    const auto strict = read(text);
    ASSERT_FALSE(strict);
    EXPECT_NE(strict.error().message.find("model.obj: line 6"), std::string::npos) << strict.error().message;
    EXPECT_EQ(scene_.node_count(), 1u);
    const auto lenient = read(text, true);
    ASSERT_TRUE(lenient) << lenient.error().message;
    EXPECT_EQ(lenient->warnings.size(), 1u);
    EXPECT_DOUBLE_EQ(area(0), 1.0);
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
  const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(0));
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
    const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(0));
    return std::pair(mesh.positions.size(), mesh.normals.size());
  };
  using Sizes = std::pair<std::size_t, std::size_t>;
  EXPECT_EQ(vertices("f 1//1 2//1 3//1\nf 1//1 3//1 2//1\n"), Sizes(3, 3));
  EXPECT_EQ(vertices("f 1//1 2//1 3//1\nf 1//2 3//1 2//1\n"), Sizes(4, 4));
  EXPECT_EQ(vertices("f 1//1 2//1 3//1\nf 1//2 3 2//1\n"), Sizes(3, 0));     // a corner without
  EXPECT_EQ(vertices("f 1//1 2//1 3//1\nf 1//3 3//1 2//1\n"), Sizes(3, 0));  // a normal that is no direction
}

TEST_F(ObjReader, MaterialsOfSeveralFiles) {
  write("a.mtl", "newmtl red\nKd 2 -1 0.5\n");
  write("b.mtl", "newmtl green\nKd 0 1 1e999\n");
  const auto report = read(
      "mtllib a.mtl\nmtllib b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl green\nf 1 2 3\nusemtl red\nf 1 2 3\n"
      "usemtl none\nf 1 2 3\n");
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(scene_.item_count(), 3u);
  std::map<std::string, core::vec3> colours;
  for (core::ItemId i = 0; i < 3; ++i)
    if (const core::MaterialId m = scene_.item_material(i); m.valid())
      colours[scene_.material(m).name] = scene_.material(m).colour;
  EXPECT_EQ(colours, (std::map<std::string, core::vec3>{{"green", {0, 1, 0.7f}}, {"red", {1, 0, 0.5f}}}));
  ASSERT_EQ(report->warnings.size(), 1u);
  EXPECT_NE(report->warnings[0].message.find("unknown material 'none'"), std::string::npos);
}

TEST_F(ObjReader, PartsWithoutAFaceGiveNoItem) {
  ASSERT_TRUE(read("v 0 0 0\nv 1 0 0\nv 0 1 0\no good\nf 1 2 3\no bad\nf 1 2 9\n", true));
  EXPECT_EQ(scene_.item_count(), 1u);
}

}  // namespace
}  // namespace sightline::importers::obj_reader_test
