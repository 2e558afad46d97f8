// Materials, and textures as their mean.
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/tests/importers/gltf_reading.h"

namespace sightline::importers::gltf_materials_test {
namespace {

using tests::GltfBytes;
using tests::triangle_gltf;
using Json = json::Value;
using GltfReaderMaterials = tests::GltfReading;

TEST_F(GltfReaderMaterials, MaterialsAreConvertedToSrgb) {
  GltfBytes g = triangle_gltf();
  g.add("materials", {{"name", "paint"},
                      {"pbrMetallicRoughness", {{"baseColorFactor", {0.214041, 1.0, 0.0, 0.25}}}},
                      {"alphaMode", "BLEND"}});
  g.add("materials", {{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.25}}}}});
  g.json["meshes"][0]["primitives"][0]["material"] = 0;
  g.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"material", 1}});
  g.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}});
  g.root({{"mesh", 0}});
  g.root({{"mesh", 0}});
  ASSERT_TRUE(read(g));
  ASSERT_EQ(scene_.material_slots(), 2u);
  const core::Material& paint = scene_.material(scene_.item_material(core::ItemId{0}));
  EXPECT_EQ(paint.name, "paint");
  EXPECT_NEAR(paint.colour.x, 0.5, 1e-4);
  EXPECT_EQ(paint.colour.y, 1.0f);
  EXPECT_EQ(paint.colour.z, 0.0f);
  EXPECT_EQ(paint.alpha, 0.25f);
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{1})).alpha, 1.0f);  // opaque, whatever its alpha
  EXPECT_FALSE(scene_.item_material(core::ItemId{2}).valid());
}

TEST_F(GltfReaderMaterials, OfTheOlderModelTheDiffuseColourIsRead) {
  GltfBytes g = tests::small_gltf();
  g.json["materials"][0] = {{"name", "bolt"},
                            {"pbrMetallicRoughness", {{"baseColorFactor", {0.0, 1.0, 0.0, 1.0}}}},
                            {"extensions",
                             {{"KHR_materials_pbrSpecularGlossiness",
                               {{"diffuseFactor", {1.0, 0.214041, 0.0, 1.0}}, {"glossinessFactor", 0.5}}}}}};
  g.json["extensionsRequired"] = Json::array({"KHR_materials_pbrSpecularGlossiness"});
  auto report = read(g);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty());
  const core::vec3 colour = scene_.material(scene_.item_material(core::ItemId{0})).colour;
  EXPECT_LT(glm::length(colour - core::vec3(1.0f, 0.5f, 0.0f)), 1e-4f);
  auto& older = g.json["materials"][0]["extensions"]["KHR_materials_pbrSpecularGlossiness"];
  older["diffuseTexture"] = {{"index", 0}};
  older["diffuseFactor"] = {1.0, 1.0, 1.0, 1.0};
  ASSERT_TRUE(read(g));
  EXPECT_NEAR(scene_.material(scene_.item_material(core::ItemId{0})).colour.x, 0.735357, 1e-4) << "mean of the texture";
  // Assimp states how much shows through in the newer model alone.
  g.json["materials"][0]["alphaMode"] = "BLEND";
  g.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][3] = 0.25;
  ASSERT_TRUE(read(g));
  EXPECT_NEAR(scene_.material(scene_.item_material(core::ItemId{0})).alpha, 0.125, 0.01) << "half of the texture is";
}

TEST_F(GltfReaderMaterials, WhatIsLeftOutIsSaidOnce) {
  GltfBytes g = triangle_gltf();
  for (int i = 0; i < 3; ++i) {
    g.add("materials",
          {{"extensions",
            {{"KHR_materials_clearcoat", {{"clearcoatFactor", 1}}}, {"KHR_materials_unlit", Json::object()}}}});
    g.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"material", i}});
  }
  g.root({{"mesh", 0}});
  expect_warning(g, "KHR_materials_clearcoat: left out of 3 materials");
  EXPECT_EQ(read(g)->warnings.size(), 1u);
}

TEST_F(GltfReaderMaterials, OnlyBlendMakesMaterialsTransparent) {
  for (const auto& [mode, alpha] : {std::pair("", 1.0f), {"OPAQUE", 1.0f}, {"MASK", 1.0f}, {"BLEND", 0.0f}}) {
    SCOPED_TRACE(mode);
    GltfBytes g = triangle_gltf();
    g.add("materials", {{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0}}}}});
    if (*mode) g.json["materials"][0]["alphaMode"] = mode;
    g.json["meshes"][0]["primitives"][0]["material"] = 0;
    g.root({{"mesh", 0}});
    ASSERT_TRUE(read(g));
    EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).alpha, alpha);
  }
}

TEST_F(GltfReaderMaterials, TexturesCountAsTheirMean) {
  // Two pixels: opaque red, and half blue without any opacity.
  GltfBytes g = tests::small_gltf();
  auto& material = g.json["materials"][0];
  material["pbrMetallicRoughness"]["baseColorFactor"] = {1.0, 1.0, 1.0, 1.0};
  ASSERT_TRUE(read(g));
  core::Material found = scene_.material(scene_.item_material(core::ItemId{0}));
  EXPECT_EQ(found.colour, core::vec3(1, 0, 0));  // blended: the second pixel does not count
  EXPECT_NEAR(found.alpha, 0.5, 1e-6);
  for (const bool said : {false, true}) {
    material.erase("alphaMode");
    if (said) material["alphaMode"] = "OPAQUE";
    ASSERT_TRUE(read(g));
    found = scene_.material(scene_.item_material(core::ItemId{0}));
    EXPECT_NEAR(found.colour.x, 0.735357, 1e-4);  // sRGB of 1/2
    EXPECT_NEAR(found.colour.z, 0.362249, 1e-4);  // of 0.2158605 / 2
    EXPECT_EQ(found.alpha, 1.0f);
  }
}

TEST_F(GltfReaderMaterials, TexturesThatCannotBeReadAreWarnings) {
  const auto expect = [&](const Json& image, const std::string& part) {
    GltfBytes g = tests::small_gltf();
    g.json["images"][0] = image;
    g.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {0.0, 1.0, 0.0, 1.0};
    const auto report = read(g);
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_EQ(report->warnings.size(), 1u) << part;
    EXPECT_NE(report->warnings[0].message.find(part), std::string::npos) << report->warnings[0].message;
    EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).colour, core::vec3(0, 1, 0));
  };
  expect({{"uri", "missing.png"}}, "'missing.png' not found");
  expect({{"uri", "../secret.png"}}, "refused");
  expect({{"uri", "https://example.com/a.png"}}, "refused");
  expect({{"uri", "data:image/png;base64,AAAA"}}, "expected a PNG or JPEG");
  expect({{"bufferView", 99}}, "expected one of the");
  expect(Json::object(), "bufferView");
  // 9000 x 9000 pixels in a hundred bytes.
  expect(
      {{"uri",
        "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAIygAACMoCAYAAABt1XK6AAAAC0lEQVR42mNggAMAAAsAAaAuyIUAAAAASUVORK5"
        "CYII="}},
      "at most");
}

/// A PNG of one pixel. `zlib` are its compressed bytes in chunks, each with the length that it claims.
std::string png_of_one_pixel(std::initializer_list<std::pair<std::uint32_t, std::vector<std::uint8_t>>> zlib) {
  std::vector<std::byte> png;
  const auto put = [&](std::initializer_list<int> bytes) {
    for (const int b : bytes) png.push_back(std::byte(b));
  };
  put({0x89, 'P', 'N', 'G', 13, 10, 26, 10, 0, 0, 0, 13, 'I', 'H', 'D', 'R', 0, 0, 0, 1, 0, 0, 0, 1, 8, 6, 0, 0, 0});
  put({0, 0, 0, 0});
  for (const auto& [length, bytes] : zlib) {
    put({int(length >> 24), int(length >> 16), int(length >> 8), int(length), 'I', 'D', 'A', 'T'});
    for (const std::uint8_t b : bytes) put({b});
    put({0, 0, 0, 0});
  }
  put({0, 0, 0, 0, 'I', 'E', 'N', 'D', 0, 0, 0, 0});
  return "data:image/png;base64," + tests::base64(png);
}

std::string one_pixel(std::uint8_t red, std::uint8_t green, std::uint8_t blue, std::uint8_t alpha) {
  // Stored without compression.
  return png_of_one_pixel({{16, {0x78, 1, 1, 5, 0, 250, 255, 0, red, green, blue, alpha, 0, 0, 0, 0}}});
}

/// zlib data of 2 MB of zeros in 13 KB: a literal and copies of 258 bytes, by the fixed codes of RFC 1951.
std::vector<std::uint8_t> swelling_zeros() {
  std::vector<std::uint8_t> zlib = {0x78, 1};
  int used = 8;
  const auto put = [&](std::string_view bits) {
    for (const char bit : bits) {
      if (used == 8) zlib.push_back(0), used = 0;
      zlib.back() |= std::uint8_t((bit - '0') << used++);
    }
  };
  put("110");  // the last block, of fixed codes
  put("00110000");
  for (int i = 0; i < 8000; ++i) put("1100010100000");
  put("0000000");
  zlib.resize(zlib.size() + 4);
  return zlib;
}

TEST_F(GltfReaderMaterials, ImagesThatClaimMoreThanTheyHold) {
  const std::vector<std::uint8_t> pixel = {0x78, 1, 1, 5, 0, 250, 255, 0, 1, 2, 3, 4, 0, 0, 0, 0};
  const std::vector<std::uint8_t> zeros = swelling_zeros();
  // stb_image alone reads the first one, takes 2 GiB for the second one, and does not return from the third one.
  for (const std::string& image :
       {png_of_one_pixel({{std::uint32_t(zeros.size()), zeros}}), png_of_one_pixel({{0x7abfe010u, pixel}}),
        png_of_one_pixel({{16, pixel}, {0xc0000000u, pixel}})}) {
    GltfBytes g = tests::small_gltf();
    g.json["images"][0] = {{"uri", image}};
    const auto report = read(g);
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_EQ(report->warnings.size(), 1u);
    EXPECT_NE(report->warnings[0].message.find("expected a whole image"), std::string::npos)
        << report->warnings[0].message;
  }
}

TEST_F(GltfReaderMaterials, DarkAndInvisibleTextures) {
  GltfBytes g = tests::small_gltf();
  auto& material = g.json["materials"][0];
  material["pbrMetallicRoughness"]["baseColorFactor"] = {1.0, 1.0, 1.0, 1.0};
  g.json["images"][0] = {{"uri", one_pixel(2, 10, 11, 0)}};
  const auto report = read(g);  // blended: nothing of the texture is seen
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty()) << report->warnings[0].message;
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).colour, core::vec3(1.0f));
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).alpha, 0.0f);
  material["alphaMode"] = "OPAQUE";
  ASSERT_TRUE(read(g));
  const core::vec3 dark = scene_.material(scene_.item_material(core::ItemId{0})).colour;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(dark[i], core::vec3(2, 10, 11)[i] / 255.0f, 1e-5f);
}

}  // namespace
}  // namespace sightline::importers::gltf_materials_test
