// Colours of vertices: one mesh for each, whatever they are stored as.
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/internal/srgb.h"
#include "sightline/importers/internal/face_colours.h"
#include "sightline/tests/importers/gltf_reading.h"

namespace sightline::importers::gltf_colours_test {
namespace {

using core::dvec3;
using tests::GltfBytes;
using Json = json::Value;

class GltfColours : public tests::GltfReading {
 protected:
  /// Two triangles apart, their corners red and half-bright blue.
  template <class T>
  static GltfBytes two_triangles(T full, T half, int components, bool normalized) {
    GltfBytes g;
    const int positions = g.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0}, "VEC3");
    std::vector<T> colours;
    for (int v = 0; v < 6; ++v) {
      for (int c = 0; c < 3; ++c) colours.push_back(v < 3 ? (c == 0 ? full : T(0)) : (c == 2 ? half : T(0)));
      if (components == 4) colours.push_back(half);
      // A stride that is a multiple of 4, as the specification asks for.
      for (int c = components; c < 4 && sizeof(T) < 4; ++c) colours.push_back(T(9));
    }
    const int stride = int(sizeof(T)) * (sizeof(T) < 4 ? 4 : components);
    const int colour =
        g.add("accessors", {{"bufferView", g.view(colours.data(), colours.size() * sizeof(T), std::size_t(stride))},
                            {"componentType", GltfBytes::type_code<T>()},
                            {"count", 6},
                            {"type", components == 3 ? "VEC3" : "VEC4"},
                            {"normalized", normalized}});
    g.mesh({{"attributes", {{"POSITION", positions}, {"COLOR_0", colour}}}});
    g.root({{"mesh", 0}});
    return g;
  }
  core::Material look(core::ItemId item) const { return scene_.material(scene_.item_material(item)); }
};

TEST_F(GltfColours, EveryTypeOfColour) {
  const auto expect = [&](const GltfBytes& g, double half) {
    const auto report = read(g);
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_EQ(scene_.item_count(), 2u);
    EXPECT_EQ(look(core::ItemId{0}).name, "#ff0000");
    EXPECT_EQ(look(core::ItemId{0}).colour, core::vec3(1, 0, 0));
    EXPECT_EQ(look(core::ItemId{0}).alpha, 1.0f);  // no material blends it
    EXPECT_NEAR(look(core::ItemId{1}).colour.z, core::srgb_from_linear(half), 0.5 / 255);
    EXPECT_EQ(look(core::ItemId{1}).colour.x, 0.0f);
    expect_corners(core::ItemId{0}, {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}});
    expect_corners(core::ItemId{1}, {{5, 0, 0}, {6, 0, 0}, {5, 0, 1}});
  };
  for (const int components : {3, 4}) {
    SCOPED_TRACE(components);
    expect(two_triangles(1.0f, 0.5f, components, false), 0.5);
    for (const bool normalized : {true, false}) {
      expect(two_triangles<std::uint8_t>(255, 128, components, normalized), 128.0 / 255);
      expect(two_triangles<std::uint16_t>(65535, 32768, components, normalized), 32768.0 / 65535);
    }
  }
  expect(two_triangles(7.0f, 0.5f, 3, false), 0.5);  // beyond white is white
  expect(two_triangles(std::nanf(""), 0.5f, 3, false), 0.5);
}

TEST_F(GltfColours, MaterialsAreMultiplied) {
  GltfBytes g = two_triangles(1.0f, 0.5f, 4, false);
  g.add("materials", {{"name", "paint"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 1.0, 0.25, 0.5}}}}});
  g.json["meshes"][0]["primitives"][0]["material"] = 0;
  ASSERT_TRUE(read(g));
  EXPECT_NEAR(look(core::ItemId{0}).colour.x, core::srgb_from_linear(0.5), 0.005);
  EXPECT_NEAR(look(core::ItemId{1}).colour.z, core::srgb_from_linear(0.125), 0.005);
  EXPECT_EQ(look(core::ItemId{0}).alpha, 1.0f);
  EXPECT_EQ(look(core::ItemId{0}).name, "paint #ff0000");
  g.json["materials"][0]["alphaMode"] = "BLEND";
  ASSERT_TRUE(read(g));
  EXPECT_NEAR(look(core::ItemId{0}).alpha, 0.25, 0.003);
  EXPECT_EQ(look(core::ItemId{0}).name, "paint #ff000080");

  // White everywhere is what exporters write without a thought: it leaves the material as it was.
  GltfBytes white = tests::triangle_gltf();
  white.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] =
      white.accessor<std::uint8_t>({255, 255, 255, 255, 255, 255, 255, 255, 255}, "VEC3", true);
  white.add("materials", {{"name", "paint"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 1.0, 0.25, 0.5}}}}});
  white.json["meshes"][0]["primitives"][0]["material"] = 0;
  white.root({{"mesh", 0}});
  ASSERT_TRUE(read(white));
  EXPECT_EQ(scene_.item_count(), 1u);
  EXPECT_EQ(look(core::ItemId{0}).name, "paint");
  EXPECT_NEAR(look(core::ItemId{0}).colour.x, core::srgb_from_linear(0.5), 1e-6);
}

TEST_F(GltfColours, InvisibleBlackIsBlack) {
  GltfBytes g = tests::triangle_gltf();
  g.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = g.floats(std::vector<float>(12, 0.0f), "VEC4");
  g.root({{"mesh", 0}});
  ASSERT_TRUE(read(g));
  EXPECT_EQ(look(core::ItemId{0}).colour, core::vec3(0.0f));
  EXPECT_EQ(look(core::ItemId{0}).alpha, 1.0f);
}

/// Against the plainest way: each triangle's colour from its own corners, compared one by one.
TEST_F(GltfColours, RandomMeshesKeepEachTrianglesColour) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const std::size_t vertices = 3 + random() % 60, triangles = 1 + random() % 80, palette = 1 + random() % 4;
    std::vector<float> positions, colours;
    std::vector<core::vec3> looks;
    for (std::size_t i = 0; i < palette; ++i)
      looks.emplace_back(float(random() % 256) / 255.0f, float(random() % 256) / 255.0f,
                         float(random() % 256) / 255.0f);
    for (std::size_t v = 0; v < vertices; ++v) {
      // Distinct and exact in float.
      for (const float x : {float(v), float(v * v % 97), float(v * 31 % 89)}) positions.push_back(x);
      const core::vec3& look = looks[random() % palette];
      for (int c = 0; c < 3; ++c) colours.push_back(look[c]);
    }
    std::vector<std::uint16_t> indices;
    for (std::size_t i = 0; i < 3 * triangles; ++i) indices.push_back(std::uint16_t(random() % vertices));
    GltfBytes g;
    g.mesh({{"attributes", {{"POSITION", g.floats(positions, "VEC3")}, {"COLOR_0", g.floats(colours, "VEC3")}}},
            {"indices", g.accessor(indices, "SCALAR")}});
    g.root({{"mesh", 0}});
    ASSERT_TRUE(read(g));

    using Triangle = std::array<long, 12>;  // corners and colour, rounded
    std::map<Triangle, int> expected, found;
    for (std::size_t t = 0; t < triangles; ++t) {
      Triangle key;
      dvec3 sum(0.0);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t v = indices[3 * t + k];
        const double x = positions[3 * v], y = positions[3 * v + 1], z = positions[3 * v + 2];
        key[3 * k] = std::lround(x), key[3 * k + 1] = std::lround(-z), key[3 * k + 2] = std::lround(y);
        for (int c = 0; c < 3; ++c) sum[c] += double(colours[3 * v + std::size_t(c)]);
      }
      for (int c = 0; c < 3; ++c) key[9 + std::size_t(c)] = std::lround(255 * core::srgb_from_linear(sum[c] / 3.0));
      ++expected[key];
    }
    for (core::ItemId item{0}; to_index(item) < scene_.item_slots(); ++item) {
      const auto all = corners(item);
      for (std::size_t t = 0; t < all.size(); t += 3) {
        Triangle key;
        for (std::size_t k = 0; k < 3; ++k)
          for (int c = 0; c < 3; ++c) key[3 * k + std::size_t(c)] = std::lround(all[t + k][c]);
        for (int c = 0; c < 3; ++c) key[9 + std::size_t(c)] = std::lround(255 * double(look(item).colour[c]));
        ++found[key];
      }
    }
    EXPECT_EQ(found, expected);
  }
}

TEST_F(GltfColours, CopiesShareTheMeshOfEachColour) {
  GltfBytes g = two_triangles(1.0f, 0.5f, 3, false);
  g.root({{"mesh", 0}, {"translation", {0, 9, 0}}});
  const int places = g.floats({1, 0, 0, 2, 0, 0}, "VEC3");
  g.root({{"mesh", 0}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", places}}}}}}}});
  ASSERT_TRUE(read(g));
  EXPECT_EQ(scene_.item_count(), 8u);
  EXPECT_LE(scene_.mesh_slots(), 2u);
  EXPECT_EQ(scene_.material_slots(), 2u);
  for (core::ItemId item{0}; to_index(item) < 8; ++item)
    EXPECT_EQ(look(item).name, look(core::ItemId{to_index(item) % 2}).name);
  expect_corners(core::ItemId{3}, {{5, 0, 9}, {6, 0, 9}, {5, 0, 10}});
  expect_corners(core::ItemId{6}, {{2, 0, 0}, {3, 0, 0}, {2, 0, 1}});
}

TEST_F(GltfColours, ShadesBecomeTheirAverage) {
  for (const std::size_t shades : {kMostFaceColours, kMostFaceColours + 1}) {
    GltfBytes g;
    std::vector<float> positions, colours;
    for (std::size_t i = 0; i < 3 * shades; ++i) {
      const std::size_t shade = i / 3;
      positions.insert(positions.end(), {float(i), float(i % 3), 0.0f});
      colours.insert(colours.end(),
                     {float(core::linear_from_srgb(double(shade % 256) / 255)), shade < 256 ? 0.0f : 1.0f, 0.0f});
    }
    g.mesh({{"attributes", {{"POSITION", g.floats(positions, "VEC3")}, {"COLOR_0", g.floats(colours, "VEC3")}}}});
    g.root({{"mesh", 0}});
    const auto report = read(g);
    ASSERT_TRUE(report);
    ASSERT_EQ(scene_.item_count(), shades == kMostFaceColours ? shades : 1u);
    ASSERT_EQ(report->warnings.size(), shades == kMostFaceColours ? 0u : 1u);
    if (shades == kMostFaceColours) continue;
    EXPECT_EQ(report->warnings[0].message.find("more than 256 colours"), 0u);
    EXPECT_NEAR(look(core::ItemId{0}).colour.x, 0.5, 0.01);
    EXPECT_EQ(corners(core::ItemId{0}).size(), 3 * shades);
  }
}

TEST_F(GltfColours, DamageCostsTheColoursAlone) {
  const std::string where = "/meshes/0/primitives/0/attributes/COLOR_0: ";
  const auto with = [&](int colours, GltfBytes& g) {
    g.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = colours;
    g.root({{"mesh", 0}});
  };
  GltfBytes few = tests::triangle_gltf();
  with(few.floats({1, 1, 1}, "VEC3"), few);
  expect_warning(few, where + "expected 3 colours, found 1; colours of vertices left out");
  EXPECT_EQ(scene_.item_count(), 1u);
  GltfBytes flat = tests::triangle_gltf();
  with(flat.floats({1, 1, 1}, "SCALAR"), flat);
  expect_warning(flat, where + "expected VEC3 or VEC4");
  GltfBytes none = tests::triangle_gltf();
  with(9, none);
  expect_warning(none, where + "expected one of the 1 accessors, found 9");
}

}  // namespace
}  // namespace sightline::importers::gltf_colours_test
