// Well-formed PLY files, and what the reader says of damage. hostile_test.cpp has damage in numbers.
#include "sightline/importers/ply/internal/ply_reader.h"

#include <array>
#include <bit>
#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "sightline/importers/internal/face_colours.h"
#include "sightline/tests/support/places.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::importers::ply_reader_test {
namespace {

using core::dvec3;

/// Bytes of a PLY file: text or numbers of either order.
struct Bytes {
  std::string text;
  bool big = false;

  template <class T>
  Bytes& put(T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (big != (std::endian::native == std::endian::big)) std::reverse(raw, raw + sizeof(T));
    text.append(raw, sizeof(T));
    return *this;
  }
};

class PlyReader : public testing::Test {
 protected:
  core::Expected<ImportReport> read(const std::string& text, const ImportOptions& options = {}) {
    scene_ = core::Scene();
    return read_ply(std::as_bytes(std::span(text)), "model.ply", scene_, scene_.root(), options);
  }
  const core::Mesh& mesh(core::ItemId item = core::ItemId{0}) const { return scene_.mesh(scene_.mesh_of(item)); }
  /// The point of a mesh's vertex, in the file's node.
  dvec3 point(std::size_t vertex, core::ItemId item = core::ItemId{0}) const {
    return core::transform_point(scene_.placement(item), dvec3(mesh(item).positions[vertex]));
  }
  const core::Material& material(core::ItemId item = core::ItemId{0}) const {
    return scene_.material(scene_.item_material(item));
  }
  core::Scene scene_;
};

const std::string kSquare =
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

TEST_F(PlyReader, Text) {
  const auto report = read("ply\nformat ascii 1.0\ncomment made by hand\n" + kSquare);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty());
  ASSERT_EQ(scene_.item_count(), 1u);
  EXPECT_EQ(report->items[std::size_t(core::Kind::kMesh)], 1u);
  EXPECT_EQ(scene_.name(report->nodes[0]), "model.ply");
  EXPECT_EQ(mesh().indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(point(2), dvec3(1, 1, 0));
  EXPECT_FALSE(scene_.item_material(core::ItemId{0}).valid());
  EXPECT_TRUE(scene_.commit());
}

TEST_F(PlyReader, LineEndsOfAllSystems) {
  for (const std::string end : {"\r\n", "\r"}) {
    std::string text;
    for (const char c : "ply\nformat ascii 1.0\n" + kSquare) text += c == '\n' ? end : std::string(1, c);
    const auto report = read(text);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(mesh().indices.size(), 6u);
  }
}

/// Vertices of all types with unknown properties between, an unknown element with lists, lists of all types.
std::string every_type(bool big) {
  Bytes b;
  b.big = big;
  b.text = std::string("ply\nformat binary_") + (big ? "big" : "little") +
           "_endian 1.0\nobj_info x\nelement vertex 3\n"
           "property char a\nproperty uint16 b\nproperty double x\nproperty short y\nproperty float32 z\n"
           "property list uchar float32 c\nproperty float nx\nproperty float ny\nproperty float nz\n"
           "element camera 2\nproperty list int double view\nproperty uint d\n"
           "element empty 18446744073709551615\n"
           "element plain 3\nproperty int16 e\nproperty double f\n"
           "element face 2\nproperty uchar flags\nproperty list ushort uchar vertex_index\n"
           "property list uchar float texcoord\n"
           "element face 2\nproperty list double float vertex_indices\n"
           "end_header\n";
  for (int i = 0; i < 3; ++i) {
    b.put(std::int8_t(-1)).put(std::uint16_t(65535)).put(1e7 + 0.0001 * i).put(std::int16_t(-300 + i));
    b.put(0.5f * float(i * i)).put(std::uint8_t(i));
    for (int k = 0; k < i; ++k) b.put(3.5f);
    b.put(0.0f).put(0.0f).put(-1.0f);
  }
  for (int i = 0; i < 2; ++i) b.put(std::int32_t(2)).put(1.0).put(2.0).put(std::uint32_t(7));
  for (int i = 0; i < 3; ++i) b.put(std::int16_t(1)).put(double(NAN));
  for (int i = 0; i < 2; ++i) {
    b.put(std::uint8_t(1)).put(std::uint16_t(3));
    for (int k = 0; k < 3; ++k) b.put(std::uint8_t((i + k) % 3));
    b.put(std::uint8_t(6));
    for (int k = 0; k < 6; ++k) b.put(0.25f);
  }
  for (int i = 0; i < 2; ++i) b.put(3.0).put(2.0f).put(1.0f).put(0.0f);
  return b.text;
}

TEST_F(PlyReader, EveryTypeInEitherOrder) {
  for (const bool big : {false, true}) {
    const auto report = read(every_type(big));
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_EQ(report->warnings.size(), 2u);
    EXPECT_EQ(report->warnings[0].message, "element 'camera': 2 are not imported");
    EXPECT_EQ(mesh().indices, (std::vector<std::uint32_t>{0, 1, 2, 1, 2, 0, 2, 1, 0, 2, 1, 0}));
    EXPECT_EQ(mesh().normals, std::vector<core::vec3>(3, {0, 0, -1}));
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(point(std::size_t(i)).x, 1e7 + 0.0001 * i, 1e-8);
      EXPECT_EQ(point(std::size_t(i)).y, -300 + i);
      EXPECT_EQ(point(std::size_t(i)).z, 0.5 * i * i);
    }
  }
}

/// A triangle along x with the greatest or least numbers of a type.
template <class T>
std::string at_the_limit(const std::string& type, T limit, int inwards, bool big) {
  Bytes b;
  b.big = big;
  b.text = std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\nelement vertex 3\nproperty " +
           type + " x\nproperty uchar y\nproperty uchar z\nelement face 1\nproperty list uchar uchar vertex_indices\n" +
           "end_header\n";
  for (int i = 0; i < 3; ++i) b.put(T(limit + T(inwards * i))).put(std::uint8_t(i == 2)).put(std::uint8_t(0));
  b.put(std::uint8_t(3)).put(std::uint8_t(0)).put(std::uint8_t(1)).put(std::uint8_t(2));
  return b.text;
}

TEST_F(PlyReader, TypesKeepTheirRange) {
  const auto expect = [&](const std::string& type, auto zero) {
    using T = decltype(zero);
    for (const bool big : {false, true})
      for (const bool least : {false, true}) {
        SCOPED_TRACE(type + (big ? " big" : " little") + (least ? " least" : " greatest"));
        const T limit = least ? std::numeric_limits<T>::lowest() : std::numeric_limits<T>::max();
        ASSERT_TRUE(read(at_the_limit<T>(type, limit, least ? 1 : -1, big)));
        for (int i = 0; i < 3; ++i) EXPECT_EQ(point(std::size_t(i)).x, double(limit) + (least ? i : -i));
      }
  };
  expect("char", std::int8_t{}), expect("uchar", std::uint8_t{});
  expect("short", std::int16_t{}), expect("ushort", std::uint16_t{});
  expect("int", std::int32_t{}), expect("uint", std::uint32_t{});
}

TEST_F(PlyReader, FarCoordinatesKeepTheirDigits) {
  const auto report = read(
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "10000000.0001 -20000000 0\n+10000000.0002 -20000000 0\n1.00000000001E7 -20000000.0001 0\n3 0 1 2\n",
      {.metres_per_unit = 0.001, .up = UpAxis::kY});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->metres_per_unit, 0.001);
  EXPECT_NEAR(point(0).x, 10000000.0001, 1e-8);
  EXPECT_NEAR(point(1).x, 10000000.0002, 1e-8);
  EXPECT_NEAR(point(2).y, -20000000.0001, 1e-8);
  // y up: the file's -y is the scene's -z... in metres.
  const dvec3 world = core::transform_point(scene_.world_from_node(report->nodes[0]), point(0));
  EXPECT_NEAR(world.x, 10000.0000001, 1e-9);
  EXPECT_NEAR(world.z, -20000.0, 1e-9);
}

TEST_F(PlyReader, FacesHaveTheMeanOfTheirVertices) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  ASSERT_TRUE(read(head + "property uchar red\nproperty uchar green\nproperty uchar blue\n" + faces +
                   "0 0 0 255 0 10\n1 0 0 255 0 20\n0 1 0 0 51 30\n3 0 1 2\n"));
  EXPECT_EQ(material().name, "#d51b15");  // in linear light
  EXPECT_EQ(material().alpha, 1.0f);
  ASSERT_TRUE(read(head + "property float red\nproperty float green\nproperty float blue\nproperty ushort alpha\n" +
                   faces + "0 0 0 1 0 nan 32896\n1 0 0 1 -3 0 32896\n0 1 0 1 0 0 32896\n3 0 1 2\n"));
  EXPECT_EQ(material().name, "#ff000080");
  EXPECT_EQ(material().alpha, 128.0f / 255.0f);
}

TEST_F(PlyReader, ColoursHaveTheNamesOfSeveralPrograms) {
  const std::vector<std::array<std::string, 4>> all = {
      {"red", "green", "blue", "alpha"},
      {"Red", "Green", "Blue", "Alpha"},
      {"r", "g", "b", "a"},
      {"r", "g", "b", "alpha"},
      {"diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"}};
  const std::string points = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string list = "element face 1\nproperty list uchar int vertex_indices\n";
  for (const auto& names : all)
    for (const auto& [type, colour] : {std::pair("float", " 1 0.5 0 0.2"),
                                       {"double", " 1.0 0.5 0 0.2"},
                                       {"uchar", " 255 128 0 51"},
                                       {"ushort", " 65535 32768 0 13107"}}) {
      SCOPED_TRACE(names[0] + " as " + type);
      std::string properties;
      for (const std::string& name : names) properties += std::string("property ") + type + " " + name + "\n";
      const std::string c = colour;
      ASSERT_TRUE(read("ply\nformat ascii 1.0\n" + points + properties + list + "end_header\n0 0 0" + c + "\n1 0 0" +
                       c + "\n0 1 0" + c + "\n3 0 1 2\n"));
      EXPECT_EQ(material().name, "#ff800033");
      ASSERT_TRUE(read("ply\nformat ascii 1.0\n" + points + list + properties +
                       "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2" + c + "\n"));
      EXPECT_EQ(material().name, "#ff800033");
    }
  // A radius is no red where the colours have other names.
  ASSERT_TRUE(read("ply\nformat ascii 1.0\n" + points + "property float r\nproperty uchar red\nproperty uchar green\n" +
                   "property uchar blue\n" + list +
                   "end_header\n0 0 0 0.7 1 2 3\n1 0 0 0.7 1 2 3\n0 1 0 0.7 1 2 3\n3 0 1 2\n"));
  EXPECT_EQ(material().name, "#010203");
}

TEST_F(PlyReader, AlphaThatIsZeroThroughoutIsNoAlpha) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string colour = "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  ASSERT_TRUE(read(head + colour + faces + "0 0 0 9 9 9 0\n1 0 0 9 9 9 0\n0 1 0 9 9 9 0\n3 0 1 2\n"));
  EXPECT_EQ(material().name, "#090909");
  EXPECT_EQ(material().alpha, 1.0f);
  ASSERT_TRUE(read(head + colour + faces + "0 0 0 9 9 9 0\n1 0 0 9 9 9 0\n0 1 0 9 9 9 255\n3 0 1 2\n"));
  EXPECT_EQ(material().name, "#09090955");

  const auto read_faces = [&](const std::string& list) {
    const auto count = std::to_string(std::count(list.begin(), list.end(), '\n'));
    return read(head + "element face " + count + "\nproperty list uchar int vertex_indices\n" + colour +
                "end_header\n0 0 0\n1 0 0\n0 1 0\n" + list);
  };
  ASSERT_TRUE(read_faces("3 0 1 2 1 2 3 0\n"));
  EXPECT_EQ(material().name, "#010203");
  ASSERT_TRUE(read_faces("3 0 1 2 1 2 3 0\n3 0 1 2 4 5 6 0\n3 0 1 2 0 0 0 0\n"));
  ASSERT_EQ(scene_.item_count(), 3u);
  EXPECT_EQ(material(core::ItemId{0}).name, "#010203");
  EXPECT_EQ(material(core::ItemId{1}).name, "#040506");
  EXPECT_EQ(material(core::ItemId{1}).alpha, 1.0f);
  EXPECT_FALSE(scene_.item_material(core::ItemId{2}).valid());
  // Where some faces can be seen, the others may well be hidden.
  ASSERT_TRUE(read_faces("3 0 1 2 1 2 3 0\n3 0 1 2 4 5 6 1\n"));
  EXPECT_EQ(material(core::ItemId{0}).alpha, 0.0f);
  EXPECT_EQ(material(core::ItemId{1}).alpha, 1.0f / 255.0f);
}

/// A fan of triangles about vertex 0, each with a colour.
std::string coloured_faces(std::size_t faces, std::size_t colours) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(faces + 2) +
                     "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(faces) +
                     "\nproperty list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\n"
                     "property uchar blue\nend_header\n";
  for (std::size_t i = 0; i < faces + 2; ++i) text += std::to_string(i) + " " + std::to_string(i * i) + " 0\n";
  for (std::size_t i = 0; i < faces; ++i)
    text += "3 0 " + std::to_string(i + 1) + " " + std::to_string(i + 2) + " " + std::to_string(i % colours / 256) +
            " " + std::to_string(i % colours % 256) + " 7\n";
  return text;
}

TEST_F(PlyReader, FaceColoursBecomeItems) {
  for (const std::size_t colours : {std::size_t(1), std::size_t(3), kMostFaceColours}) {
    const std::size_t faces = 2 * colours + 1;
    const auto report = read(coloured_faces(faces, colours));
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_EQ(scene_.item_count(), colours);
    for (core::ItemId item{0}; to_index(item) < colours; ++item) {
      EXPECT_EQ(material(item).colour, core::vec3(0, float(item), 7) / 255.0f);
      std::size_t triangle = 0;
      for (std::size_t face = to_index(item); face < faces; face += colours, ++triangle)
        for (std::size_t c = 0; c < 3; ++c) {
          const std::size_t vertex = c == 0 ? 0 : face + c;
          ASSERT_EQ(point(mesh(item).indices[3 * triangle + c], item), dvec3(vertex, vertex * vertex, 0));
        }
      EXPECT_EQ(mesh(item).indices.size(), 3 * triangle);
    }
  }
  const auto report = read(coloured_faces(1000, kMostFaceColours + 1));
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->warnings.size(), 1u);
  ASSERT_EQ(scene_.item_count(), 1u);
  EXPECT_EQ(mesh().indices.size(), 3000u);
  EXPECT_EQ(material().name, "#007c07");
}

TEST_F(PlyReader, PolygonsKeepTheirColours) {
  const auto report = read(
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nproperty float "
      "nx\n"
      "property float ny\nproperty float nz\nelement face 3\nproperty list uchar int vertex_indices\nproperty uchar "
      "red\n"
      "property uchar green\nproperty uchar blue\nend_header\n"
      "0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n-1 0 0 1 0 0\n"
      "3 0 3 4 1 2 3\n4 0 1 2 3 9 9 9\n3 0 1 2 1 2 3\n");
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(scene_.item_count(), 2u);
  EXPECT_EQ(mesh(core::ItemId{0}).indices.size(), 6u);
  EXPECT_EQ(mesh(core::ItemId{1}).indices.size(), 6u);
  EXPECT_EQ(mesh(core::ItemId{1}).positions.size(), 4u);
  EXPECT_EQ(mesh(core::ItemId{1}).normals, std::vector<core::vec3>(4, {0, 0, 1}));
}

/// A triangle in text with more properties of its vertices; each vertex ends with `values`.
std::string triangle_with(const std::string& properties, const std::string& values,
                          const std::string& format = "format ascii 1.0\n") {
  return "ply\n" + format + "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n" + properties +
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 " + values + "\n1 0 0 " + values +
         "\n0 1 0 " + values + "\n3 0 1 2\n";
}

TEST_F(PlyReader, PropertiesCountOnceAndTogether) {
  const std::string rgb = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  ASSERT_TRUE(read(triangle_with("property double red\nproperty double green\nproperty double blue\n", "1 0 0.5")));
  EXPECT_EQ(material().name, "#ff0080");
  ASSERT_TRUE(read(triangle_with(rgb + "property uchar diffuse_red\nproperty uchar x\n", "1 2 3 9 7")));
  EXPECT_EQ(material().name, "#010203");
  EXPECT_EQ(point(1), dvec3(1, 0, 0));
  ASSERT_TRUE(read(triangle_with("property list uchar uchar red\n" + rgb, "1 9 1 2 3")));
  EXPECT_EQ(material().name, "#010203");
  ASSERT_TRUE(read(triangle_with("property uchar red\nproperty float nx\n", "9 1")));
  EXPECT_FALSE(scene_.item_material(core::ItemId{0}).valid());
  EXPECT_TRUE(mesh().normals.empty());
}

TEST_F(PlyReader, HeadersMayHoldCommentsAnywhere) {
  EXPECT_TRUE(read(triangle_with("", "", "comment first\nobj_info second\nformat ascii 1.0\n\ncomment third\n")));
  const auto expect = [&](const std::string& format, const std::string& message) {
    const auto report = read(triangle_with("", "", format));
    ASSERT_FALSE(report);
    EXPECT_NE(report.error().message.find(message), std::string::npos) << report.error().message;
  };
  expect("format ascii 1.1\n", "line 2: expected version 1.0, found '1.1'");
  expect("format ascii 1.0\nprope\x01\x80ty\n",
         "line 3: expected comment, element, property or end_header, found 'prope??ty'");
  expect("format ascii 1.0\nelement extra 4x\n", "line 3: expected how many elements there are, found '4x'");
  expect("format ascii 1.0\nelement extra 99999999999999999999\n", "line 3: expected how many elements");
}

TEST_F(PlyReader, FacesOfSeveralElements) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string list = "property list uchar int vertex_indices\n", points = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
  ASSERT_TRUE(read(head + "element face 1\n" + list + "element face 1\n" + list +
                   "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n" + list +
                   "end_header\n" + points + "3 0 1 2\n3 1 2 3 1 2 3\n3 0 1 3\n"));
  ASSERT_EQ(scene_.item_count(), 2u);
  EXPECT_FALSE(scene_.item_material(core::ItemId{0}).valid());
  EXPECT_EQ(mesh(core::ItemId{0}).indices.size(), 6u);
  EXPECT_EQ(material(core::ItemId{1}).name, "#010203");
  EXPECT_EQ(mesh(core::ItemId{1}).indices.size(), 3u);
  // The second triangle of a strip is turned, wherever in the list the strip begins.
  ASSERT_TRUE(read(head + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" + points +
                   "5 -1 0 1 2 3\n"));
  EXPECT_EQ(mesh().indices, (std::vector<std::uint32_t>{0, 1, 2, 2, 1, 3}));
  // A list's length is a whole number.
  for (const char* length : {"2.5", "nan", "-1", "1e10"})
    EXPECT_FALSE(read(head + "element face 1\nproperty list float int vertex_indices\nend_header\n" + points + length +
                      " 0 1 2\n"))
        << length;
}

TEST_F(PlyReader, MeansOfColoursAreRounded) {
  const std::string rgb = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  std::string text = triangle_with(rgb, "1 2 3");
  text.replace(text.find("0 0 0 1 2 3"), 11, "0 0 0 3 3 3");
  ASSERT_TRUE(read(text));
  EXPECT_EQ(material().name, "#020203");  // of 5/3, 7/3 and 3
}

TEST_F(PlyReader, StripsTurnEverySecondTriangle) {
  const auto report = read(
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
      "element tristrips 2\nproperty list int int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 0 1 2 3 4 -1 0 1 3\n4 -1 4 3 -1\n");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(mesh().indices, (std::vector<std::uint32_t>{0, 1, 2, 2, 1, 3, 2, 3, 4, 0, 1, 3}));
}

TEST_F(PlyReader, PointsGiveNoItem) {
  const auto report = read(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 "
      "3\n");
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->warnings.size(), 2u);
  EXPECT_EQ(report->warnings[0].message, "no faces: 1 points are not imported");
  EXPECT_EQ(report->warnings[1].message, "nothing to draw: the file has no items");
  EXPECT_EQ(scene_.item_count(), 0u);
  EXPECT_EQ(scene_.node_count(), 2u);
}

TEST_F(PlyReader, DamageNamesThePlace) {
  const std::string head = "ply\nformat ascii 1.0\n";
  struct Case {
    std::string what, with, message;
    std::size_t triangles;  // when lenient
  };
  const Case cases[] = {
      {"4 0 1 2 3", "4 0 1 2 4", "line 14: expected vertices from 0 to 3", 0},
      {"4 0 1 2 3", "4 0 1 2 -1", "line 14: expected vertices from 0 to 3", 0},
      {"4 0 1 2 3", "4 0 1 2 1.5", "line 14: expected vertices from 0 to 3", 0},
      {"4 0 1 2 3", "4000000000 0 1 2 3", "line 14: expected a list as long as it says in 'face' 0", 0},
      {"4 0 1 2 3", "-4 0 1 2 3", "line 14: expected a list's length in 'face' 0", 0},
      {"4 0 1 2 3", "4 0 1 2", "line 14: expected a list as long as it says in 'face' 0", 0},
      {"1 1 0", "1 1", "line 12: expected more numbers in 'vertex' 2, found the line's end", 0},
      {"1 1 0", "no number at all\n1 1 0", "line 12: expected numbers in 'vertex' 2", 2},
      {"4 0 1 2 3", "", "expected 1 of 'face'", 0},
      {"1 1 0", "1 one 0", "line 12: expected numbers in 'vertex' 2", 0},
      {"face 1", "face 2", "expected 2 of 'face'", 2},
      {"face 1", "face 18446744073709551615", "expected 18446744073709551615 of 'face'", 2},
      {"vertex 4", "vertex 4000000000", "expected 4000000000 of 'vertex'", 0},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.what + " -> " + c.with);
    std::string text = head + kSquare;
    text.replace(text.find(c.what), c.what.size(), c.with);
    const auto strict = read(text);
    ASSERT_FALSE(strict);
    EXPECT_NE(strict.error().message.find("model.ply: line "), std::string::npos) << strict.error().message;
    EXPECT_NE(strict.error().message.find(c.message), std::string::npos) << strict.error().message;
    EXPECT_EQ(scene_.node_count(), 1u);
    const auto lenient = read(text, {.lenient = true});
    ASSERT_TRUE(lenient) << lenient.error().message;
    EXPECT_FALSE(lenient->warnings.empty());
    EXPECT_EQ(scene_.item_count() ? mesh().indices.size() / 3 : 0u, c.triangles);
  }
}

/// One warning that begins so.
void expect_warning(const core::Expected<ImportReport>& report, const std::string& message) {
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->warnings.size(), 1u);
  EXPECT_EQ(report->warnings[0].message, message);
}

TEST_F(PlyReader, LinesAmongTheDataThatAreNone) {
  const std::string head = "ply\nformat ascii 1.0\n";
  struct Case {
    std::string what, with, message;
  };
  const Case cases[] = {
      {"0 0 0\n", "\ncomment x\n0 0 0\n# y\n// z\n\n",
       "line 12: comments and empty lines among the data are skipped (2 times)"},
      {"0 0 0\n", "0 0 0 7 8\n", "line 10: numbers beyond an element's own are ignored"},
      {"4 0 1 2 3", "4 0 1 2 3 255", "line 14: numbers beyond an element's own are ignored"},
      {"0 0 0\n1 0 0\n", "0 0 0 -1\n1 0 0 .5\n", "line 10: numbers beyond an element's own are ignored (2 times)"},
      {"0 0 0\n", "0 0 0 the origin\n", "line 10: text behind an element's numbers is ignored"},
      {"4 0 1 2 3", "4 0 1\n2 3", "line 15: an element that goes on in the next line is read"},
      {"4 0 1 2 3\n", "4 0 1 2 3\n\n\nmore of it\n", "line 17: 11 bytes after the last element are ignored"},
  };
  for (const Case& c : cases)
    for (const bool lenient : {false, true}) {
      SCOPED_TRACE(c.with);
      std::string text = head + kSquare;
      text.replace(text.find(c.what), c.what.size(), c.with);
      expect_warning(read(text, {.lenient = lenient}), c.message);
      ASSERT_EQ(scene_.item_count(), 1u);
      EXPECT_EQ(mesh().indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
    }
}

TEST_F(PlyReader, LenientLosesTheLineAlone) {
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 5\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
      "3 0 1 2\n3 0 1\nx 0 1 2\n3 0 1 7\n3 0 2 3\n";
  EXPECT_FALSE(read(text));
  const auto report = read(text, {.lenient = true});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->warnings.size(), 3u);
  EXPECT_EQ(mesh().indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
}

TEST_F(PlyReader, WhatIsNotNeededIsLostAlone) {
  const std::string rgb = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  expect_warning(read(triangle_with(rgb, "red 2 3")),
                 "line 13: words in place of numbers, but for coordinates and corners, are left out (3 times)");
  EXPECT_FALSE(scene_.item_material(core::ItemId{0}).valid());
  expect_warning(read(triangle_with(rgb, "1 2")),
                 "line 13: missing numbers, but for coordinates and corners, are left out (3 times)");
  EXPECT_EQ(mesh().indices.size(), 3u);
  const std::string normal = "property float nx\nproperty float ny\nproperty float nz\n";
  std::string text = triangle_with(normal, "1 0 0");
  text.replace(text.find("0 1 0 1 0 0"), 11, "0 1 0 nan nan nan");
  expect_warning(read(text), "1 normals that are not finite become those of the faces");
  EXPECT_EQ(mesh().normals, (std::vector<core::vec3>{{1, 0, 0}, {1, 0, 0}, {0, 0, 1}}));
}

TEST_F(PlyReader, WideNumbers) {
  const std::string body =
      "element vertex 3\nproperty int64 x\nproperty uint64 y\nproperty float z\nelement face 1\n"
      "property list uint64 int64 vertex_indices\nend_header\n";
  ASSERT_TRUE(read("ply\nformat ascii 1.0\n" + body + "-1 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
  EXPECT_EQ(mesh().indices.size(), 3u);
  for (const bool big : {false, true}) {
    Bytes b;
    b.big = big;
    b.text = std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\n" + body;
    for (int i = 0; i < 3; ++i) b.put(std::int64_t(-5000000000 + i)).put(std::uint64_t(i == 2)).put(0.0f);
    b.put(std::uint64_t(3)).put(std::int64_t(0)).put(std::int64_t(1)).put(std::int64_t(2));
    const auto report = read(b.text);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(point(2), dvec3(-4999999998.0, 1, 0));
  }
}

TEST_F(PlyReader, HeadersThatBendTheSpecification) {
  expect_warning(read("\xef\xbb\xbfply\nformat ascii 1.0\n" + kSquare), "line 1: a byte order mark is skipped");
  expect_warning(read("ply\nformat ascii 1.0\nCreated by a program\nhttp://x\n" + kSquare),
                 "line 3: lines without a keyword are skipped (2 times)");
  expect_warning(read("ply\nCreated by a program\nformat ascii 1.0\n" + kSquare),
                 "line 2: a line without a keyword is skipped");
  EXPECT_TRUE(read("PLY \nFormat ASCII 1.0\n" + kSquare));
  for (const char* line : {"elemnt vertex 3\n", "propery float x\n", "end_heade\n", "endheader\n"})
    EXPECT_FALSE(read("ply\nformat ascii 1.0\n" + std::string(line) + kSquare, {.lenient = true})) << line;
  EXPECT_FALSE(read("ply\n" + kSquare));
  // A line that is skipped may have been a property. What is left in the end tells.
  const auto with = [&](const std::string& line, const std::string& more) {
    Bytes b{"ply\nformat binary_little_endian 1.0\n" + line +
            "element vertex 3\nproperty float x\nproperty float y\n"
            "property float z\nelement face 1\nproperty list uchar uchar vertex_indices\nend_header\n"};
    for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) b.put(x);
    return b.text + std::string("\3\0\1\2", 4) + more;
  };
  EXPECT_TRUE(read(with("", "")));
  expect_warning(read(with("credit\n", "")), "line 3: a line without a keyword is skipped");
  expect_warning(read(with("", "more")), "byte 211: 4 bytes after the last element are ignored");
  EXPECT_FALSE(read(with("credit\n", "more")));
}

TEST_F(PlyReader, NotFiniteIsDroppedAndListed) {
  for (const std::string bad : {"nan", "-inf", "1e999", "2e36"}) {
    SCOPED_TRACE(bad);
    std::string text = "ply\nformat ascii 1.0\n" + kSquare;
    text.replace(text.find("1 1 0"), 1, bad);
    const auto report = read(text);
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_EQ(report->warnings.size(), 2u);
    EXPECT_EQ(report->warnings[1].message, "nothing to draw: none of the 1 items has a volume or an area");
    EXPECT_TRUE(mesh().indices.empty());
    EXPECT_TRUE(scene_.commit());
  }
}

TEST_F(PlyReader, CancelLeavesTheSceneAlone) {
  const std::string text = coloured_faces(50000, 3);
  double last = -1.0;
  int calls = 0;
  ASSERT_TRUE(read(text, {.progress = [&](double share) {
                     EXPECT_GT(share, last);
                     last = share;
                     return ++calls > 0;
                   }}));
  EXPECT_EQ(last, 1.0);
  EXPECT_GT(calls, 10);
  for (const double at : {0.0, 0.1, 0.5}) {
    const auto report = read(text, {.progress = [&](double share) { return share < at; }});
    ASSERT_FALSE(report);
    EXPECT_EQ(report.error().message, kCancelled);
    EXPECT_EQ(scene_.node_count(), 1u);
    EXPECT_EQ(scene_.mesh_slots() + scene_.material_slots() + scene_.item_slots(), 0u);
  }
}

TEST_F(PlyReader, FilesOfVtk) {
  // Written by vtkPLYWriter of VTK 9.1 from a vtkConeSource of 12 sides, height 2 and radius 0.5, triangulated.
  for (const char* name : {"cone_vtk.ply", "cone_vtk_text.ply"}) {
    const auto report = import_file(tests::in_checkout("tests/data") / name, scene_, scene_.root());
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->warnings.empty());
    const core::ItemId item = core::ItemId(scene_.item_count() - 1);
    EXPECT_EQ(mesh(item).positions.size(), 13u);
    EXPECT_EQ(mesh(item).indices.size(), 3u * 22);
    const core::AabbD box = scene_.bounds_under(item, scene_.placement(item));
    EXPECT_NEAR(box.min.x, -1.0, 1e-7);
    EXPECT_NEAR(box.max.y, 0.5, 1e-7);
  }
}

TEST_F(PlyReader, RealFile) {
  SIGHTLINE_NEED_DATA("meshes/stanford-bunny.ply");
  const auto report = import_file(tests::data_path("meshes/stanford-bunny.ply"), scene_, scene_.root());
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->warnings.size(), 1u);
  EXPECT_EQ(report->warnings[0].message, kSeemsYUp);
  EXPECT_EQ(mesh().indices.size(), 3u * 69451);
  EXPECT_EQ(mesh().positions.size(), 34834u);  // of 35947, the others are in no face
  EXPECT_TRUE(scene_.commit());
}

}  // namespace
}  // namespace sightline::importers::ply_reader_test
