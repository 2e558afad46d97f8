// Accessors, and the triangles that primitives make of them.
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "sightline/tests/importers/gltf_reading.h"

namespace sightline::importers::gltf_meshes_test {
namespace {

using core::dvec3;
using tests::GltfBytes;
using tests::triangle_gltf;
using Json = json::Value;
using GltfReaderMeshes = tests::GltfReading;

TEST_F(GltfReaderMeshes, EveryComponentType) {
  const auto expect = [&](GltfBytes g, int positions, double scale) {
    g.mesh({{"attributes", {{"POSITION", positions}}}});
    g.root({{"mesh", 0}});
    const auto report = read(g);
    ASSERT_TRUE(report) << report.error().message;
    expect_corners(core::ItemId{0}, {{scale, 0, 0}, {0, 0, scale}, {0, -scale, 0}});
  };
  const auto with = [&]<class T>(T one) {
    for (const bool normalized : {false, true}) {
      if (std::is_same_v<T, float> && normalized) continue;
      GltfBytes g;
      const int positions = g.accessor<T>({one, 0, 0, 0, one, 0, 0, 0, one}, "VEC3", normalized);
      expect(g, positions, normalized ? double(one) / double(std::numeric_limits<T>::max()) : double(one));
    }
  };
  with(std::int8_t{100}), with(std::uint8_t{200}), with(std::int16_t{30000}), with(std::uint16_t{60000}), with(2.5f);
  // The most negative value of a normalised type stands for -1, too.
  GltfBytes g;
  const int positions = g.accessor<std::int8_t>({-128, 0, 0, 0, -128, 0, 0, 0, -128}, "VEC3", true);
  expect(g, positions, -1.0);
}

TEST_F(GltfReaderMeshes, IndexTypesStridesStripsAndFans) {
  // Five points in a plane, interleaved with numbers that mean nothing.
  const std::vector<float> points = {0, 0, 0, 9, 1, 0, 0, 9, 1, 1, 0, 9, 0, 1, 0, 9, -1, 0.5f, 0, 9};
  const dvec3 p[] = {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}, {-1, 0, 0.5}};
  const auto file = [&](int mode, auto type) {
    using T = decltype(type);
    GltfBytes g;
    const int view = g.view(points.data(), points.size() * 4, 16);
    const int positions =
        g.add("accessors", {{"bufferView", view}, {"componentType", 5126}, {"count", 5}, {"type", "VEC3"}});
    const int indices = g.accessor<T>({0, 1, 2, 0, 2, 3}, "SCALAR");
    g.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"mode", mode}});
    g.root({{"mesh", 0}});
    return g;
  };
  const std::vector<dvec3> plain = {p[0], p[1], p[2], p[0], p[2], p[3]};
  ASSERT_TRUE(read(file(4, std::uint8_t{})));
  expect_corners(core::ItemId{0}, plain);
  ASSERT_TRUE(read(file(4, std::uint16_t{})));
  expect_corners(core::ItemId{0}, plain);
  ASSERT_TRUE(read(file(4, std::uint32_t{})));
  expect_corners(core::ItemId{0}, plain);
  // 0 1 2 | 2 1 0 turned | 2 0 2 empty | 2 0 3 turned: 0 3 2 … by the rule of the specification.
  ASSERT_TRUE(read(file(5, std::uint8_t{})));
  expect_corners(core::ItemId{0}, {p[0], p[1], p[2], p[1], p[0], p[2], p[0], p[3], p[2]});
  ASSERT_TRUE(read(file(6, std::uint8_t{})));
  expect_corners(core::ItemId{0}, {p[1], p[2], p[0], p[2], p[3], p[0]});
}

TEST_F(GltfReaderMeshes, StripsAreStitchedWithEmptyTriangles) {
  for (const std::vector<std::uint8_t>& strip :
       {std::vector<std::uint8_t>{0, 0, 1, 2}, {0, 1, 2, 2}, {0, 1, 0}, {0, 1, 1}}) {
    GltfBytes g = triangle_gltf();
    auto& primitive = g.json["meshes"][0]["primitives"][0];
    primitive["mode"] = 5, primitive["indices"] = g.accessor(strip, "SCALAR");
    g.root({{"mesh", 0}});
    ASSERT_TRUE(read(g));
    EXPECT_EQ(scene_.mesh(scene_.mesh_of(core::ItemId{0})).indices.size(), strip.size() == 4 ? 3u : 0u);
  }
  GltfBytes g = triangle_gltf();
  g.json["meshes"][0]["primitives"][0]["indices"] = g.accessor<std::int8_t>({0, 1, -1}, "SCALAR");
  g.root({{"mesh", 0}});
  expect_damage(g, "/meshes/0/primitives/0/indices: expected indices below the 3 vertices, found 1 triangles beyond");
}

TEST_F(GltfReaderMeshes, PointsAndLinesAreLeftOut) {
  GltfBytes g = triangle_gltf();
  g.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 0}});
  g.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 3}});
  g.root({{"mesh", 0}});
  const auto report = read(g);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(scene_.item_count(), 1u);
  ASSERT_EQ(report->warnings.size(), 1u);
}

TEST_F(GltfReaderMeshes, PrimitivesTakeTheirVerticesOfALongList) {
  std::vector<float> positions, normals;
  for (int i = 0; i < 40; ++i) {
    positions.insert(positions.end(), {float(i), float(i * i), 0.0f});
    normals.insert(normals.end(), {float(i), 0.0f, 1.0f});
  }
  for (const std::vector<std::uint8_t>& indices : {std::vector<std::uint8_t>{10, 11, 12}, {10, 35, 20}}) {
    GltfBytes g;
    const Json attributes = {{"POSITION", g.floats(positions, "VEC3")}, {"NORMAL", g.floats(normals, "VEC3")}};
    g.mesh({{"attributes", attributes}, {"indices", g.accessor(indices, "SCALAR")}});
    g.root({{"mesh", 0}});
    ASSERT_TRUE(read(g));
    const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(core::ItemId{0}));
    ASSERT_EQ(mesh.positions.size(), 3u);
    for (std::size_t c = 0; c < 3; ++c) {
      const double i = indices[c];
      EXPECT_LT(glm::distance(corners(core::ItemId{0})[c], dvec3(i, 0, i * i)), 1e-4);
      EXPECT_EQ(mesh.normals[mesh.indices[c]], core::vec3(float(i), 0, 1));
    }
    g.json["accessors"][1]["count"] = 39;
    expect_warning(g, "/meshes/0/primitives/0/attributes/NORMAL: expected 40 normals, found 39; normals left out");
    EXPECT_EQ(corners(core::ItemId{0}).size(), 3u);
    EXPECT_TRUE(scene_.mesh(scene_.mesh_of(core::ItemId{0})).normals.empty());
    g.json["accessors"][1]["count"] = 40;
  }
}

/// Accessors of random types, strides, offsets and sparse changes against numbers kept beside them.
TEST_F(GltfReaderMeshes, RandomAccessorsHoldTheirNumbers) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const std::size_t count = 3 + random() % 40;
    const bool base = random() % 4 != 0, sparse = random() % 2 != 0;
    const std::size_t stride = 12 + 4 * (random() % 4), offset = 4 * (random() % 3);
    std::vector<dvec3> expected(count, dvec3(0.0));
    std::vector<float> data((offset + count * stride) / 4 + 3, 77.0f);
    for (std::size_t i = 0; base && i < count; ++i)
      for (int k = 0; k < 3; ++k) {
        const float value = float(int(random() % 2001) - 1000);
        data[(offset + i * stride) / 4 + std::size_t(k)] = value;
        expected[i][k] = value;
      }
    GltfBytes g;
    Json accessor = {{"componentType", 5126}, {"count", count}, {"type", "VEC3"}};
    if (base) {
      accessor["bufferView"] = g.view(data.data(), data.size() * 4, stride);
      accessor["byteOffset"] = offset;
    }
    if (sparse) {
      std::vector<std::uint16_t> which;
      std::vector<float> values;
      for (std::size_t i = 0; i < count; ++i) {
        if (random() % 3) continue;
        which.push_back(std::uint16_t(i));
        for (int k = 0; k < 3; ++k) values.push_back(float(expected[i][k] = int(random() % 100)));
      }
      which.push_back(0), values.insert(values.end(), 3, 0.0f);  // so that no view is empty
      accessor["sparse"] = {
          {"count", which.size() - 1},
          {"indices", {{"bufferView", g.view(which.data(), which.size() * 2)}, {"componentType", 5123}}},
          {"values", {{"bufferView", g.view(values.data(), values.size() * 4)}}}};
    }
    const int positions = g.add("accessors", accessor);
    // Few corners of many vertices and many corners of few take different ways.
    std::vector<std::uint32_t> indices;
    for (std::size_t i = 0, n = 3 * (1 + random() % 30); i < n; ++i) indices.push_back(std::uint32_t(random() % count));
    g.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", g.accessor(indices, "SCALAR")}});
    g.root({{"mesh", 0}});
    const auto report = read(g);
    ASSERT_TRUE(report) << report.error().message;
    std::vector<dvec3> wanted;
    for (const std::uint32_t i : indices) wanted.emplace_back(expected[i].x, -expected[i].z, expected[i].y);
    expect_corners(core::ItemId{0}, wanted, 1e-3);
    ASSERT_FALSE(HasFailure());
  }
}

TEST_F(GltfReaderMeshes, ElementsEndWithinTheirView) {
  const auto file = [](std::size_t length, std::size_t offset, std::size_t count) {
    GltfBytes g = triangle_gltf();
    g.binary.resize(64);
    g.json["bufferViews"][0] = {{"buffer", 0}, {"byteLength", length}, {"byteStride", 16}};
    g.json["accessors"][0]["byteOffset"] = offset, g.json["accessors"][0]["count"] = count;
    g.root({{"mesh", 0}});
    return g;
  };
  EXPECT_TRUE(read(file(44, 0, 3)));
  expect_damage(file(43, 0, 3), "/accessors/0: expected 3 elements of 12 bytes, 16 apart");
  EXPECT_TRUE(read(file(48, 4, 3)));
  expect_damage(file(47, 4, 3), "/accessors/0: expected 3 elements");
  EXPECT_TRUE(read(file(48, 48, 0)));
  expect_damage(file(48, 49, 0), "/accessors/0: expected 0 elements");
}

TEST_F(GltfReaderMeshes, SparseIndicesRiseBelowTheCount) {
  const auto file = [](const std::vector<std::uint8_t>& indices) {
    GltfBytes g;
    const int base = g.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, "VEC3");
    const std::vector<float> values = {5, 0, 0, 6, 0, 0};
    g.json["accessors"][std::size_t(base)]["sparse"] = {
        {"count", indices.size()},
        {"indices", {{"bufferView", g.view(indices.data(), indices.size())}, {"componentType", 5121}}},
        {"values", {{"bufferView", g.view(values.data(), 12 * indices.size())}}}};
    g.mesh({{"attributes", {{"POSITION", base}}}, {"mode", 5}});
    g.root({{"mesh", 0}});
    return g;
  };
  ASSERT_TRUE(read(file({1, 3})));
  expect_corners(core::ItemId{0}, {{0, 0, 0}, {5, 0, 0}, {0, 0, 1}, {5, 0, 0}, {6, 0, 0}, {0, 0, 1}});
  const std::string where = "/accessors/0/sparse/indices: expected rising indices below 4, found ";
  expect_damage(file({4}), where + "4 at place 0");
  expect_damage(file({3, 4}), where + "4 at place 1");
  expect_damage(file({2, 2}), where + "2 at place 1");
  expect_damage(file({2, 1}), where + "1 at place 1");
}

TEST_F(GltfReaderMeshes, FarFromTheOriginKeepsDetail) {
  GltfBytes g;
  // A square of 0.2 mm, 10,000 km away by its node; another whose bytes say 16 m steps and whose node scales them.
  g.mesh({{"attributes", {{"POSITION", g.floats({0, 0, 0, 2e-4f, 0, 0, 0, 2e-4f, 0}, "VEC3")}}}});
  g.root({{"mesh", 0}, {"translation", {1e7, 1e7, 1e7}}});
  // Integers hold 24 bits and more: a mesh whose own numbers lie far out is re-centred before it becomes float.
  const int far = g.accessor<std::uint32_t>({4000000001u, 0, 0, 4000000000u, 1, 0, 4000000000u, 0, 1}, "VEC3");
  g.mesh({{"attributes", {{"POSITION", far}}}});
  g.root({{"mesh", 1}});
  const auto report = read(g);
  ASSERT_TRUE(report) << report.error().message;
  expect_corners(core::ItemId{0}, {{1e7, -1e7, 1e7}, {1e7 + 2e-4, -1e7, 1e7}, {1e7, -1e7, 1e7 + 2e-4}}, 1e-8);
  expect_corners(core::ItemId{1}, {{4000000001.0, 0, 0}, {4000000000.0, 0, 1}, {4000000000.0, -1, 0}}, 1e-6);
}

TEST_F(GltfReaderMeshes, IndicesBeyondTheVerticesCostTheirTriangles) {
  GltfBytes g = triangle_gltf();
  g.json["meshes"][0]["primitives"][0]["indices"] =
      g.accessor<std::uint16_t>({0, 1, 2, 0, 1, 3, 0, 65535, 2}, "SCALAR");
  g.root({{"mesh", 0}});
  expect_damage(g, "/meshes/0/primitives/0/indices: expected indices below the 3 vertices, found 2 triangles beyond");
  EXPECT_EQ(corners(core::ItemId{0}).size(), 3u);
}

TEST_F(GltfReaderMeshes, GeometryThatIsNotFiniteIsDropped) {
  GltfBytes g;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  g.mesh({{"attributes", {{"POSITION", g.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, nan, 0, 0, 0, 1, 0}, "VEC3")}}}});
  g.root({{"mesh", 0}});
  const auto report = read(g);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->warnings.size(), 1u);
  EXPECT_EQ(corners(core::ItemId{0}).size(), 3u);
}

}  // namespace
}  // namespace sightline::importers::gltf_meshes_test
