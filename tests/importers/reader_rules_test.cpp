// The rule of import.h, for every reader: what other programs write is read, what is bad loses itself alone, nothing is
// left out in silence, lenient imports keep what is outside the damage, and all text is UTF-8. One file of each format
// holds two squares, which a test spoils in one place.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "sightline/importers/import.h"
#include "sightline/importers/internal/text_encoding.h"
#include "sightline/tests/importers/gltf_bytes.h"

namespace sightline::importers::reader_rules_test {
namespace {

namespace fs = std::filesystem;

/// Squares of area 1 and 4 in the plane z = 0, the normals along z.
struct Content {
  std::string name = "part";
  std::string normal = "0 0 1";  ///< of the first corner
  std::string corner = "1 1 0";  ///< the third of the first square
  int squares = 2;
};

std::vector<std::string> corners_of(const Content& content, int square) {
  if (square == 0) return {"0 0 0", "1 0 0", content.corner, "0 1 0"};
  return {"10 0 0", "12 0 0", "12 2 0", "10 2 0"};
}

std::string obj(const Content& content) {
  std::string text = "o " + content.name + "\nvn " + content.normal + "\nvn 0 0 1\n", faces;
  for (int square = 0; square < 2; ++square) {
    for (const std::string& corner : corners_of(content, square)) text += "v " + corner + "\n";
    if (square < content.squares) faces += square == 0 ? "f 1//1 2//2 3//2 4//2\n" : "f 5//2 6//2 7//2 8//2\n";
  }
  return text + faces;
}

std::string stl(const Content& content) {
  std::string text = "solid " + content.name + "\n";
  for (int square = 0; square < content.squares; ++square) {
    const std::vector<std::string> corners = corners_of(content, square);
    for (const std::size_t second : {1u, 2u})
      text += fmt::format("facet normal {}\nouter loop\nvertex {}\nvertex {}\nvertex {}\nendloop\nendfacet\n",
                          content.normal, corners[0], corners[second], corners[second + 1]);
  }
  return text + "endsolid " + content.name + "\n";
}

std::string ply(const Content& content) {
  std::string text = "ply\nformat ascii 1.0\ncomment " + content.name +
                     "\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\n"
                     "property float ny\nproperty float nz\n";
  text += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n", content.squares);
  for (int square = 0; square < 2; ++square) {
    const std::vector<std::string> corners = corners_of(content, square);
    for (std::size_t i = 0; i < 4; ++i)
      text += corners[i] + " " + (square == 0 && i == 0 ? content.normal : "0 0 1") + "\n";
  }
  for (int square = 0; square < content.squares; ++square) text += square == 0 ? "4 0 1 2 3\n" : "4 4 5 6 7\n";
  return text;
}

std::string rev(const Content& content) {
  std::string text = "HEAD\n1 2\ninfo\nnote\ndate\nuser\nUnicode UTF-8\nMODL\n1 1\nproject\nname\nCNTB\n1 2\n" +
                     content.name + "\n0 0 0\n1\n";
  if (content.squares > 0) {
    text += "PRIM\n1 1\n11\n.001 0 0 0\n0 .001 0 0\n0 0 .001 0\n0 0 0\n12 2 0\n2\n";
    for (int square = 0; square < 2; ++square) {
      text += "1\n4\n";
      const std::vector<std::string> corners = corners_of(content, square);
      for (std::size_t i = 0; i < 4; ++i)
        text += corners[i] + "\n" + (square == 0 && i == 0 ? content.normal : "0 0 1") + "\n";
    }
  }
  return text + "CNTE\n1 2\nEND:\n1 1\n";
}

std::string gltf(const Content& content) {
  std::vector<float> numbers;
  for (int square = 0; square < 2; ++square)
    for (const std::string& corner : corners_of(content, square)) {
      float x = 0, y = 0, z = 0;
      std::sscanf(corner.c_str(), "%f %f %f", &x, &y, &z);
      numbers.insert(numbers.end(), {x, z, -y});  // y up
    }
  for (std::size_t i = 0; i < 8; ++i) numbers.insert(numbers.end(), {0, 1, 0});
  if (content.normal.starts_with("nan")) numbers[24] = std::nanf("");
  std::vector<std::byte> bytes(96 * 2);
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  for (const unsigned i : {0u, 1u, 2u, 0u, 2u, 3u, 4u, 5u, 6u, 4u, 6u, 7u})
    for (const int shift : {0, 8}) bytes.push_back(std::byte(i >> shift & 0xff));
  const std::string mesh = R"({"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}]})";
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"name": ")" +
         content.name + R"(")" + (content.squares > 0 ? R"(, "mesh": 0)" : "") + R"(}], "meshes": [)" + mesh +
         R"(], "buffers": [{"byteLength": 216, "uri": "data:application/octet-stream;base64,)" + tests::base64(bytes) +
         R"("}], "bufferViews": [{"buffer": 0, "byteLength": 192}, {"buffer": 0, "byteOffset": 192, "byteLength": 24}],
         "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, -2],
         "max": [12, 0, 0]}, {"bufferView": 0, "byteOffset": 96, "componentType": 5126, "count": 8, "type": "VEC3"},
         {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}]})";
}

std::string normals_of(const Content& content) {
  std::string text = content.normal;
  for (int i = 1; i < 8; ++i) text += " 0 0 1";
  return text;
}

std::string points_of(const Content& content) {
  std::string text;
  for (int square = 0; square < 2; ++square)
    for (const std::string& corner : corners_of(content, square)) text += corner + "\n";
  return text;
}

std::string vtk(const Content& content) {
  return "# vtk DataFile Version 3.0\n" + content.name + "\nASCII\nDATASET POLYDATA\nPOINTS 8 double\n" +
         points_of(content) + (content.squares > 0 ? "POLYGONS 2 10\n4 0 1 2 3\n4 4 5 6 7\n" : "") +
         "POINT_DATA 8\nNORMALS n float\n" + normals_of(content) + "\n";
}

std::string vtp(const Content& content) {
  const std::string polys = content.squares > 0 ? "2" : "0";
  return R"(<?xml version="1.0"?><VTKFile type="PolyData" version="1.0" byte_order="LittleEndian"><PolyData>
<FieldData><Array type="String" Name=")" +
         content.name + R"(" NumberOfTuples="1" format="ascii">65 0</Array></FieldData>
<Piece NumberOfPoints="8" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys=")" +
         polys +
         R"("><PointData Normals="n"><DataArray type="Float32" Name="n" NumberOfComponents="3" format="ascii">)" +
         normals_of(content) + R"(</DataArray></PointData><Points><DataArray type="Float64" NumberOfComponents="3"
format="ascii">)" +
         points_of(content) +
         R"(</DataArray></Points><Polys><DataArray type="Int64" Name="connectivity" format="ascii">)" +
         (content.squares > 0 ? "0 1 2 3 4 5 6 7" : "") +
         R"(</DataArray><DataArray type="Int64" Name="offsets" format="ascii">)" + (content.squares > 0 ? "4 8" : "") +
         "</DataArray></Polys></Piece></PolyData></VTKFile>";
}

struct Format {
  std::string extension;
  std::function<std::string(const Content&)> write;
  bool named = true;         ///< names reach the scene
  bool normals_used = true;  ///< those of the file
};
std::ostream& operator<<(std::ostream& out, const Format& format) {
  return out << format.extension;
}

/// The formats that this build reads.
std::vector<Format> formats() {
  std::vector<Format> all = {{".obj", obj},   {".stl", stl, true, false}, {".ply", ply, false}, {".rev", rev},
                             {".gltf", gltf}, {".vtk", vtk, false},       {".vtp", vtp}};
  const auto known = known_extensions();
  std::erase_if(all, [&](const Format& format) {
    return std::find(known.begin(), known.end(), format.extension) == known.end();
  });
  return all;
}

class ReaderRules : public testing::TestWithParam<Format> {
 protected:
  ReaderRules() : file_(fs::temp_directory_path() / fmt::format("sightline_rules_{}", getpid()) / "model") {
    fs::create_directories(file_.parent_path());
    file_ += GetParam().extension;
  }
  ~ReaderRules() override {
    std::error_code ignored;
    fs::remove_all(file_.parent_path(), ignored);
  }
  core::Expected<ImportReport> read(const std::string& content, bool lenient = false) {
    std::ofstream(file_, std::ios::binary) << content;
    scene_ = core::Scene();
    auto report = import_file(file_, scene_, scene_.root(), {.lenient = lenient});
    if (report) expect_utf8(*report);
    return report;
  }
  core::Expected<ImportReport> read(const Content& content, bool lenient = false) {
    return read(GetParam().write(content), lenient);
  }
  void expect_utf8(const ImportReport& report) const {
    for (const std::string& text : texts()) EXPECT_TRUE(is_utf8(text)) << text;
    for (const ImportWarning& warning : report.warnings) EXPECT_TRUE(is_utf8(warning.message)) << warning.message;
  }
  /// Names and attributes of the nodes.
  std::vector<std::string> texts() const {
    std::vector<std::string> all;
    scene_.for_each_node(scene_.root(),
                         [&](core::NodeId node, const core::Affine&, bool, std::uint32_t, core::MaterialId) {
                           all.emplace_back(scene_.name(node));
                           for (const auto& [key, value] : scene_.attributes(node)) {
                             all.emplace_back(key);
                             all.emplace_back(value);
                           }
                         });
    return all;
  }
  bool holds(const std::string& text) const {
    const std::vector<std::string> all = texts();
    return std::find(all.begin(), all.end(), text) != all.end();
  }
  double area() const {
    double sum = 0.0;
    for (core::ItemId item{0}; to_index(item) < scene_.item_slots(); ++item) {
      const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(item));
      const core::Affine to_world = scene_.world_from_node(scene_.node_of(item)) * scene_.placement(item);
      const auto corner = [&](std::size_t i) {
        return core::transform_point(to_world, core::dvec3(mesh.positions[mesh.indices[i]]));
      };
      for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
        sum += 0.5 * glm::length(glm::cross(corner(i + 1) - corner(i), corner(i + 2) - corner(i)));
    }
    return GetParam().extension == ".rev" ? 1e6 * sum : sum;
  }
  fs::path file_;
  core::Scene scene_;
};

TEST_P(ReaderRules, WhatIsRightIsReadWithoutAWord) {
  for (const std::string name : {"part", "Ger\xc3\xa4t 7"}) {
    const auto report = read(Content{.name = name});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->warnings.empty()) << report->warnings[0].message;
    EXPECT_NEAR(area(), 5.0, 1e-5);
    EXPECT_EQ(holds(name), GetParam().named);
  }
}

TEST_P(ReaderRules, NamesOfAnyEncodingAreDecoded) {
  const auto report = read(Content{.name = "Ger\xe4t"});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_NEAR(area(), 5.0, 1e-5);
  if (!GetParam().named) return;
  EXPECT_TRUE(holds("Ger\xc3\xa4t"));
  ASSERT_EQ(report->warnings.size(), 1u);
  EXPECT_NE(report->warnings[0].message.find("Windows-1252"), std::string::npos) << report->warnings[0].message;
}

TEST_P(ReaderRules, ByteOrderMarksAndWideTextAreRead) {
  const std::string text = GetParam().write({});
  const auto marked = read("\xef\xbb\xbf" + text);
  ASSERT_TRUE(marked) << marked.error().message;
  EXPECT_NEAR(area(), 5.0, 1e-5);
  for (const bool big : {false, true}) {
    std::string wide = big ? "\xfe\xff" : "\xff\xfe";
    for (const char c : GetParam().write({})) wide += big ? std::string{'\0', c} : std::string{c, '\0'};
    const auto report = read(wide);
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_EQ(report->warnings.size(), 1u);
    EXPECT_EQ(report->warnings[0].message, "the file is UTF-16");
    EXPECT_NEAR(area(), 5.0, 1e-5);
  }
}

TEST_P(ReaderRules, LineEndsOfAnySystem) {
  for (const std::string end : {"\r\n", "\r"}) {
    std::string text;
    for (const char c : GetParam().write({})) text += c == '\n' ? end : std::string(1, c);
    const auto report = read(text);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_NEAR(area(), 5.0, 1e-5);
  }
}

TEST_P(ReaderRules, ABadNormalLosesItselfAlone) {
  const auto report = read(Content{.normal = "nan 0 1"});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_NEAR(area(), 5.0, 1e-5);
  ASSERT_EQ(scene_.item_count(), 1u);
  const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(core::ItemId{0}));
  if (!GetParam().normals_used) return;
  EXPECT_EQ(report->warnings.size(), 1u);
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  for (const core::vec3& normal : mesh.normals) EXPECT_TRUE(core::is_finite(core::dvec3(normal)));
}

TEST_P(ReaderRules, ABadCornerCostsItsFacesAlone) {
  const auto report = read(Content{.corner = "1 nan 0"});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_FALSE(report->warnings.empty());
  EXPECT_NEAR(area(), 4.0, 1e-5);
  EXPECT_TRUE(scene_.commit());
}

TEST_P(ReaderRules, NothingToDrawIsSaid) {
  const auto report = read(Content{.squares = 0});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(area(), 0.0);
  const auto says = [](const ImportWarning& warning) { return warning.message.starts_with("nothing to draw"); };
  EXPECT_EQ(std::count_if(report->warnings.begin(), report->warnings.end(), says), 1);
}

/// Cut off anywhere: strict imports fail or have all, and lenient ones that have less say so.
TEST_P(ReaderRules, WhatIsCutOffIsSaid) {
  const std::string text = GetParam().write({});
  for (std::size_t cut = 1; cut < text.size(); ++cut) {
    SCOPED_TRACE(testing::Message() << cut << " bytes cut off");
    const auto report = read(text.substr(0, text.size() - cut), true);
    EXPECT_TRUE(!report || !report->warnings.empty() || area() > 0.49) << "less than a face of three corners";
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, ReaderRules, testing::ValuesIn(formats()),
                         [](const auto& one) { return one.param.extension.substr(1); });

}  // namespace
}  // namespace sightline::importers::reader_rules_test
