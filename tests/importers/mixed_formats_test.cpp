// One scene of every format: a cube of 2 m and a mast of 10 m, written once in each, stand side by side, equally large
// and upright, whatever the units and the up axis of their files.
#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "sightline/importers/import.h"
#include "sightline/tests/importers/rvm_bytes.h"

namespace sightline::importers::mixed_formats_test {
namespace {

/// A box in the scene, in metres, z up.
struct Box {
  core::dvec3 low, size;
};

/// Corner i has bit 0 of i along x, bit 1 along y, bit 2 along z. Faces run counter-clockwise from outside.
constexpr std::array<std::array<int, 4>, 6> kFaces{
    {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};

using Corners = std::array<core::dvec3, 8>;

/// In a file's coordinates: the inverse of what an import does.
Corners in_file(const Box& box, const ImportOptions& options) {
  Corners corners;
  for (int i = 0; i < 8; ++i) {
    const core::dvec3 p = (box.low + box.size * core::dvec3(i & 1, i >> 1 & 1, i >> 2)) / options.metres_per_unit;
    corners[std::size_t(i)] = options.up == UpAxis::kY ? core::dvec3(p.x, p.z, -p.y) : p;
  }
  return corners;
}

std::string obj(const Corners& corners) {
  std::string text = "o box\n";
  for (const core::dvec3& p : corners) text += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
  for (const auto& f : kFaces) text += fmt::format("f {} {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1, f[3] + 1);
  return text;
}

std::string ply(const Corners& corners) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\nproperty double z\n"
      "element face 6\nproperty list uchar int vertex_indices\nend_header\n";
  for (const core::dvec3& p : corners) text += fmt::format("{} {} {}\n", p.x, p.y, p.z);
  for (const auto& f : kFaces) text += fmt::format("4 {} {} {} {}\n", f[0], f[1], f[2], f[3]);
  return text;
}

std::string stl(const Corners& corners) {
  std::string text = "solid box\n";
  for (const auto& f : kFaces) {
    for (const auto& t : {std::array{f[0], f[1], f[2]}, {f[0], f[2], f[3]}}) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const int i : t) {
        const core::dvec3& p = corners[std::size_t(i)];
        text += fmt::format("vertex {} {} {}\n", p.x, p.y, p.z);
      }
      text += "endloop\nendfacet\n";
    }
  }
  return text + "endsolid box\n";
}

std::string vtk(const Corners& corners) {
  std::string text = "# vtk DataFile Version 3.0\nbox\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 double\n";
  for (const core::dvec3& p : corners) text += fmt::format("{} {} {}\n", p.x, p.y, p.z);
  return text + "CELLS 1 9\n8 0 1 3 2 4 5 7 6\nCELL_TYPES 1\n12\n";  // a hexahedron
}

std::string vtp(const Corners& corners) {
  std::string points, polygons;
  for (const core::dvec3& p : corners) points += fmt::format("{} {} {} ", p.x, p.y, p.z);
  for (const auto& f : kFaces) polygons += fmt::format("{} {} {} {} ", f[0], f[1], f[2], f[3]);
  return R"(<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="8" NumberOfPolys="6"><Points>)"
         R"(<DataArray type="Float64" NumberOfComponents="3">)" +
         points + R"(</DataArray></Points><Polys><DataArray type="Int32" Name="connectivity">)" + polygons +
         R"(</DataArray><DataArray type="Int32" Name="offsets">4 8 12 16 20 24</DataArray></Polys></Piece></PolyData>)"
         "</VTKFile>";
}

/// Millimetres, scaled by the placement.
std::string rvm(const Box& box) {
  const core::dvec3 centre = box.low + 0.5 * box.size;
  tests::RvmBytes b;
  b.head().group("box", 1).begin("PRIM").u32(1).u32(2);
  b.floats({.001f, 0, 0, 0, .001f, 0, 0, 0, .001f}).floats({float(centre.x), float(centre.y), float(centre.z)});
  for (const double sign : {-500.0, 500.0})
    for (int k = 0; k < 3; ++k) b.f32(float(sign * box.size[k]));
  for (int k = 0; k < 3; ++k) b.f32(float(1000.0 * box.size[k]));
  b.end().group_end().finish();
  return {reinterpret_cast<const char*>(b.bytes.data()), b.bytes.size()};
}

/// Metres, y up. The numbers lie in NAME.bin.
std::string gltf(const Corners& corners, const std::filesystem::path& numbers) {
  std::ofstream file(numbers, std::ios::binary);
  for (const core::dvec3& p : corners) {
    const core::vec3 q(p);
    file.write(reinterpret_cast<const char*>(&q), sizeof q);
  }
  for (const auto& f : kFaces)
    for (const int i : {f[0], f[1], f[2], f[0], f[2], f[3]}) file.put(char(i));
  return fmt::format(
      R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3","min":[{},{},{}],"max":[{},{},{}]}},
{{"bufferView":1,"componentType":5121,"count":36,"type":"SCALAR"}}],
"bufferViews":[{{"buffer":0,"byteLength":96}},{{"buffer":0,"byteOffset":96,"byteLength":36}}],
"buffers":[{{"byteLength":132,"uri":"{}"}}]}})",
      corners[0].x, corners[0].y, corners[2].z, corners[7].x, corners[7].y, corners[0].z, numbers.filename().string());
}

class MixedFormats : public testing::TestWithParam<ImportOptions> {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) / ("sightline_mixed_formats_" + std::to_string(getpid()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string content(const std::string& extension, const Box& box, const std::string& stem) const {
    const Corners corners = in_file(box, GetParam());
    if (extension == ".rvm") return rvm(box);
    if (extension == ".obj") return obj(corners);
    if (extension == ".ply") return ply(corners);
    if (extension == ".stl") return stl(corners);
    if (extension == ".vtk") return vtk(corners);
    if (extension == ".vtp") return vtp(corners);
    return gltf(in_file(box, {.up = UpAxis::kY}), folder_ / (stem + ".bin"));
  }
  std::filesystem::path write(const std::string& stem, const std::string& extension, const Box& box) const {
    const std::filesystem::path path = folder_ / (stem + extension);
    std::ofstream(path, std::ios::binary) << content(extension, box, stem);
    return path;
  }
  /// The extensions that the build reads.
  static std::vector<std::string> extensions() {
    const auto known = known_extensions();
    std::vector<std::string> all = {".rvm", ".obj", ".ply", ".stl", ".vtk", ".vtp", ".gltf"};
    std::erase_if(all, [&](const auto& e) { return std::find(known.begin(), known.end(), e) == known.end(); });
    return all;
  }
  std::filesystem::path folder_;
};

TEST_P(MixedFormats, StandSideBySide) {
  std::vector<std::filesystem::path> files;
  std::vector<Box> expected;
  double x = -20.0;
  for (const std::string& extension : extensions()) {
    for (const auto& [stem, size] : {std::pair{"cube", core::dvec3(2.0)}, {"mast", core::dvec3(0.5, 0.5, 10.0)}}) {
      expected.push_back({{x, -1.0, 3.0}, size});
      files.push_back(write(stem, extension, expected.back()));
      x += 3.0;
    }
  }
  ASSERT_GE(files.size(), 2u);
  core::Scene scene;
  const auto report = import_files(files, scene, scene.root(), GetParam());
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty()) << report->warnings[0].message;
  ASSERT_EQ(report->nodes.size(), files.size());
  ASSERT_TRUE(scene.commit());
  for (std::size_t i = 0; i < files.size(); ++i) {
    SCOPED_TRACE(files[i].filename());
    core::AabbD box;
    std::size_t items = 0;
    for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item) {
      core::NodeId node = scene.node_of(item);
      while (node != report->nodes[i] && node.valid()) node = scene.parent(node);
      if (!node.valid()) continue;
      ++items;
      const core::AabbD own =
          scene.bounds_under(item, scene.world_from_node(scene.node_of(item)) * scene.placement(item));
      box.grow(own.min);
      box.grow(own.max);
    }
    EXPECT_EQ(items, 1u);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(box.min[k], expected[i].low[k], 1e-6);
      EXPECT_NEAR(box.max[k] - box.min[k], expected[i].size[k], 1e-6);
    }
  }
}

TEST_P(MixedFormats, RefuseUnitsThatAreNoLength) {
  constexpr double kInf = std::numeric_limits<double>::infinity(), kNan = std::numeric_limits<double>::quiet_NaN();
  for (const std::string& extension : extensions()) {
    const std::filesystem::path file = write("cube", extension, {{1.0, 2.0, 3.0}, core::dvec3(2.0)});
    for (const double unit : {0.0, -0.001, kInf, -kInf, kNan}) {
      ImportOptions options = GetParam();
      options.metres_per_unit = unit;
      core::Scene scene;
      const auto report = import_file(file, scene, scene.root(), options);
      ASSERT_FALSE(report) << file << ' ' << unit;
      EXPECT_EQ(report.error().message,
                fmt::format("{}: metres_per_unit: expected a finite number above 0, found {}", file.string(), unit));
      EXPECT_EQ(scene.node_count(), 1u);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Frames, MixedFormats,
                         testing::Values(ImportOptions{.metres_per_unit = 0.001}, ImportOptions{.up = UpAxis::kY},
                                         ImportOptions{.metres_per_unit = 0.0254, .up = UpAxis::kY}));

}  // namespace
}  // namespace sightline::importers::mixed_formats_test
