// Files, scenes, nodes and their instances.
#include "sightline/importers/gltf/internal/gltf_reader.h"

#include <cmath>
#include <fstream>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sightline/importers/gltf/internal/gltf_document.h"
#include "sightline/importers/internal/side_files.h"
#include "sightline/tests/importers/gltf_reading.h"
#include "sightline/tests/support/json_pointer.h"
#include "sightline/tests/support/places.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::importers::gltf_reader_test {
namespace {

using core::dvec3;
using tests::GltfBytes;
using tests::triangle_gltf;
using Json = json::Value;
using GltfReader = tests::GltfReading;

TEST_F(GltfReader, HierarchyTransformsNamesAndAttributes) {
  GltfBytes g = triangle_gltf();
  g.json["meshes"][0]["name"] = "wedge";
  const int leaf = g.add("nodes", {{"mesh", 0},
                                   {"translation", {10, 20, 30}},
                                   {"rotation", {0, 0, std::sqrt(0.5), std::sqrt(0.5)}},
                                   {"scale", {2, 3, 4}}});
  const int arm = g.add("nodes", {{"name", "arm"},
                                  {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 100, 0, 0, 1}},
                                  {"children", {leaf}},
                                  {"extras", {{"tag", "P-100"}, {"weight", 2.5}, {"open", true}, {"list", {1, 2}}}}});
  g.root({{"name", "unit"}, {"children", {arm}}, {"extras", "note"}});
  const auto report = read(g);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty());
  EXPECT_EQ(report->items[std::size_t(core::Kind::kMesh)], 1u);
  EXPECT_EQ(scene_.path(scene_.node_of(core::ItemId{0})), "model.glb/unit/arm/wedge");
  EXPECT_EQ(scene_.attributes(find("unit")), (core::Scene::Attributes{{"extras", "note"}}));
  const auto& attributes = scene_.attributes(find("arm"));
  ASSERT_EQ(attributes.size(), 3u);  // JSON objects have no order
  EXPECT_EQ(attributes[0], (std::pair<std::string, std::string>("open", "true")));
  EXPECT_EQ(attributes[1], (std::pair<std::string, std::string>("tag", "P-100")));
  EXPECT_EQ(attributes[2], (std::pair<std::string, std::string>("weight", "2.5")));
  EXPECT_EQ(scene_.attributes(find("unit"))[0].second, "note");
  // A quarter turn about z takes x to y and y to -x; then z up: (x, y, z) -> (x, -z, y).
  expect_corners(core::ItemId{0}, {{110, -30, 22}, {104, -30, 20}, {110, -42, 20}});
}

TEST_F(GltfReader, InstancesShareTheirMesh) {
  GltfBytes g = triangle_gltf();
  g.root({{"mesh", 0}, {"translation", {5, 0, 0}}});
  g.root({{"mesh", 0}});
  const int moves = g.floats({1, 0, 0, 0, 2, 0, 0, 0, 3}, "VEC3");
  const int turns = g.accessor<std::int16_t>({0, 0, 0, 32767, 0, 0, 23170, 23170, 0, 0, 32767, 0}, "VEC4", true);
  const int scales = g.floats({1, 1, 1, 2, 2, 2, 3, 3, 3}, "VEC3");
  g.root({{"mesh", 0},
          {"extensions",
           {{"EXT_mesh_gpu_instancing",
             {{"attributes", {{"TRANSLATION", moves}, {"ROTATION", turns}, {"SCALE", scales}}}}}}}});
  const auto report = read(g);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(scene_.item_count(), 5u);
  EXPECT_EQ(scene_.mesh_slots(), 1u);
  EXPECT_EQ(report->shared_meshes, 4u);
  expect_corners(core::ItemId{0}, {{6, 0, 0}, {5, 0, 2}, {5, -3, 0}});
  expect_corners(core::ItemId{1}, {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}});
  expect_corners(core::ItemId{2}, {{2, 0, 0}, {1, 0, 2}, {1, -3, 0}});
  expect_corners(core::ItemId{3}, {{0, 0, 4}, {-4, 0, 2}, {0, -6, 2}}, 1e-5);  // a quarter turn about z, twice as large
  expect_corners(core::ItemId{4}, {{-3, -3, 0}, {0, -3, -6}, {0, -12, 0}}, 1e-5);
}

TEST_F(GltfReader, InstancesByTheThousand) {
  GltfBytes g = triangle_gltf();
  constexpr std::size_t kMany = 5003;
  const int moves = g.floats(std::vector<float>(3 * kMany, 1.0f), "VEC3");
  // The name of a collection means nothing outside the convention.
  Json attributes = {{"TRANSLATION", moves}};
  const int node = g.root({{"name", "BoxCollection"},
                           {"mesh", 0},
                           {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", attributes}}}}}});
  ASSERT_TRUE(read(g));
  EXPECT_EQ(scene_.item_count(), kMany);
  auto& stored = g.json["nodes"][std::size_t(node)]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  const std::string where = "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/SCALE: expected ";
  stored["SCALE"] = g.floats({1, 1, 1}, "VEC3");
  expect_damage(g, where + "5003 instances as the attributes before it, found 1");
  stored["SCALE"] = g.floats(std::vector<float>(kMany, 1.0f), "SCALAR");
  expect_damage(g, where + "3 numbers for each instance, found 1");
}

TEST_F(GltfReader, RotationsAboutAnyAxis) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const auto real = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    const dvec3 axis = glm::normalize(dvec3(real(-1, 1), real(-1, 1), real(-1, 1)));
    const double angle = real(-3, 3), length = real(0.5, 2);  // writers do not always keep quaternions at length 1
    const dvec3 v = length * std::sin(0.5 * angle) * axis, scale(real(0.5, 2), real(0.5, 2), real(0.5, 2));
    GltfBytes g = triangle_gltf();
    g.root({{"rotation", {v.x, v.y, v.z, length * std::cos(0.5 * angle)}}, {"scale", {scale.x, scale.y, scale.z}}});
    ASSERT_TRUE(read(g));
    const core::Affine found = scene_.transform(scene_.first_child(scene_.first_child(scene_.root())));
    for (int i = 0; i < 3; ++i) {  // Rodrigues' formula
      dvec3 e(0.0);
      e[i] = scale[i];
      const dvec3 turned = e * std::cos(angle) + glm::cross(axis, e) * std::sin(angle) +
                           axis * (glm::dot(axis, e) * (1.0 - std::cos(angle)));
      EXPECT_LT(glm::distance(found.linear[i], turned), 1e-12);
    }
  }
}

TEST_F(GltfReader, BuffersBesideTheModel) {
  GltfBytes g = triangle_gltf();
  g.root({{"mesh", 0}});
  const auto* data = reinterpret_cast<const char*>(g.binary.data());
  std::filesystem::create_directories(folder_ / "parts");
  std::ofstream(folder_ / "parts" / "a b.bin", std::ios::binary).write(data, std::streamsize(g.binary.size()));
  std::ofstream(folder_.parent_path() / "secret.bin", std::ios::binary).write(data, std::streamsize(g.binary.size()));
  const auto near = read_text(g.gltf("parts/a%20b.bin"));
  ASSERT_TRUE(near) << near.error().message;
  EXPECT_EQ(near->bytes, g.gltf("parts/a%20b.bin").size() + g.binary.size());
  expect_corners(core::ItemId{0}, {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}});
  ASSERT_TRUE(read_text(g.gltf("data:application/octet-stream;base64," + tests::base64(g.binary))));
  expect_corners(core::ItemId{0}, {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}});
  std::string escaped;  // RFC 2397 knows data without base64
  for (const auto byte : g.binary) escaped += fmt::format("%{:02x}", unsigned(byte));
  ASSERT_TRUE(read_text(g.gltf("data:application/octet-stream," + escaped)));
  expect_corners(core::ItemId{0}, {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}});
  for (const std::string other :
       {"parts\\\\a b.bin", ".\\\\parts\\\\a%20b.bin", "Parts/A B.bin", "elsewhere/a b.BIN"}) {
    const auto report = read_text(g.gltf(other));
    const bool guessed = other.starts_with("Parts") && !tests::names_ignore_case();
    if (other.starts_with("elsewhere")) {
      EXPECT_FALSE(report) << "only in the model's own folder";
      continue;
    }
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->warnings.size(), guessed ? 1u : 0u) << other;
    expect_corners(core::ItemId{0}, {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}});
  }
  for (const std::string bad : {"../secret.bin", "%2e%2e/secret.bin", "/etc/passwd", "file:///etc/passwd",
                                "missing.bin", "", "data:xyz", "data:x;base64,(/)"}) {
    const auto strict = read_text(g.gltf(bad));
    ASSERT_FALSE(strict) << bad;
    EXPECT_EQ(strict.error().message.find("model.glb: /buffers/0"), 0u) << strict.error().message;
    const auto lenient = read_text(g.gltf(bad), true);
    ASSERT_TRUE(lenient) << lenient.error().message;
    EXPECT_EQ(scene_.item_count(), 0u);
    EXPECT_EQ(lenient->warnings.size(), 2u) << "and nothing to draw";
  }
}

TEST_F(GltfReader, BothAlphabetsOfBase64) {
  GltfBytes g;
  const std::vector<std::uint8_t> bytes = {251, 239, 190, 255, 255, 255, 0, 0, 0};
  g.mesh({{"attributes", {{"POSITION", g.accessor(bytes, "VEC3")}}}});
  g.root({{"mesh", 0}});
  std::string text = tests::base64(g.binary);
  ASSERT_EQ(text.substr(0, 8), "++++////");
  ASSERT_TRUE(read_text(g.gltf("data:application/octet-stream;base64," + text)));
  const auto standard = corners(core::ItemId{0});
  ASSERT_EQ(standard.size(), 3u);
  EXPECT_NEAR(standard[0].x, 251, 1e-5);
  text.replace(0, 8, "----____");
  ASSERT_TRUE(read_text(g.gltf("data:application/octet-stream;base64," + text)));
  EXPECT_EQ(corners(core::ItemId{0}), standard);
}

TEST_F(GltfReader, PercentSigns) {
  EXPECT_EQ(percent_decoded("a%20b%"), "a b%");
  EXPECT_EQ(percent_decoded("%41"), "A");
  EXPECT_EQ(percent_decoded("x%4"), "x%4");
  EXPECT_EQ(percent_decoded("%4g%g4%zz"), "%4g%g4%zz");
}

TEST_F(GltfReader, ChunksOfBinaryFiles) {
  GltfBytes g = triangle_gltf();
  g.root({{"mesh", 0}});
  const std::vector<std::byte> glb = g.glb();
  const std::size_t json_size = std::size_t(glb[12]) | std::size_t(glb[13]) << 8, binary_at = 20 + json_size;
  const auto chunk = [](std::uint32_t kind, std::size_t bytes) {
    std::vector<std::byte> made(8 + bytes, std::byte{0x3f});
    for (int i = 0; i < 4; ++i)
      made[std::size_t(i)] = std::byte(bytes >> (8 * i)), made[std::size_t(4 + i)] = std::byte(kind >> (8 * i));
    return made;
  };
  const auto with_length = [](std::vector<std::byte> bytes, std::size_t length) {
    for (std::size_t i = 0; i < 4; ++i) bytes[8 + i] = std::byte(length >> (8 * i));
    return bytes;
  };
  const auto expect_triangle = [&](const std::vector<std::byte>& bytes) {
    const auto report = read(bytes);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->warnings.empty());
    expect_corners(core::ItemId{0}, {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}});
  };
  // Chunks of other kinds say nothing, nor does a second of the same.
  std::vector<std::byte> bytes = glb;
  const auto other = chunk(0x58585858, 36), second = chunk(0x004E4942, 36);
  bytes.insert(bytes.begin() + std::ptrdiff_t(binary_at), other.begin(), other.end());
  bytes.insert(bytes.end(), second.begin(), second.end());
  expect_triangle(with_length(bytes, bytes.size()));
  // The file ends where its header says.
  bytes = glb;
  bytes.resize(glb.size() + 20, std::byte{0xff});
  expect_triangle(bytes);
  EXPECT_FALSE(read(with_length(glb, glb.size() + 1)));
  EXPECT_TRUE(read(with_length(glb, glb.size() + 1), true));
  // Only the first buffer is the binary chunk.
  g.json["bufferViews"][0]["buffer"] = 1;
  g.json["buffers"] = {{{"byteLength", 36}}, {{"byteLength", 36}}};
  std::string text = g.json.dump();
  EXPECT_FALSE(read_text(text));
}

TEST_F(GltfReader, RequiredExtensions) {
  GltfBytes g = triangle_gltf();
  g.root({{"mesh", 0}});
  g.json["extensionsRequired"] = {"KHR_mesh_quantization", "KHR_materials_unlit", "EXT_mesh_gpu_instancing",
                                  "EXT_texture_webp"};
  EXPECT_TRUE(read(g));
  for (const std::string name : {"EXT_mesh_voxels", "KHR_gaussian_splatting"}) {
    g.json["extensionsRequired"] = Json::array({name});
    expect_damage(g, "/extensionsRequired: expected extensions that can be read, found " + name);
  }
}

TEST_F(GltfReader, DefaultSceneAndOthers) {
  GltfBytes g = triangle_gltf();
  const int a = g.add("nodes", {{"name", "a"}, {"mesh", 0}}), b = g.add("nodes", {{"name", "b"}, {"mesh", 0}});
  g.json["scenes"] = {{{"nodes", {a}}}, {{"nodes", {b}}}};
  g.json["scene"] = 1;
  const auto report = read(g);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->warnings.size(), 1u);
  EXPECT_TRUE(find("b").valid());
  EXPECT_FALSE(find("a").valid());
  g.json.erase("scenes"), g.json.erase("scene");
  ASSERT_TRUE(read(g));
  EXPECT_EQ(scene_.item_count(), 2u);
}

TEST_F(GltfReader, GraphsThatAreNoTrees) {
  GltfBytes g = triangle_gltf();
  g.root({{"mesh", 0}, {"name", "good"}});
  GltfBytes cycle = g;
  cycle.json["nodes"].push_back({{"children", {2}}});
  cycle.json["nodes"].push_back({{"children", {1}}});
  expect_damage(cycle, "/nodes/1: expected a tree");
  EXPECT_EQ(scene_.item_count(), 1u);
  GltfBytes self = g;
  self.json["nodes"].push_back({{"children", {1}}});
  self.json.erase("scenes"), self.json.erase("scene");
  expect_damage(self, "/nodes/1: expected a tree");
  EXPECT_EQ(scene_.item_count(), 1u);
  GltfBytes shared = g;
  shared.root({{"children", {0}}});
  expect_damage(shared, "/scenes/0/nodes: expected nodes without a parent");
  GltfBytes parents = g;
  parents.json["nodes"] = {{{"children", {2}}}, {{"children", {2}}}, {{"mesh", 0}}};
  parents.json["scenes"][0]["nodes"] = {0, 1};
  expect_damage(parents, "/nodes/2: expected one parent, found nodes 0 and 1");
  EXPECT_EQ(scene_.item_count(), 1u);
  GltfBytes twice = g;
  twice.json["nodes"] = {{{"children", {1, 1}}}, {{"mesh", 0}}};
  expect_damage(twice, "/nodes/1: expected one parent");
  EXPECT_EQ(scene_.item_count(), 1u);
}

/// What is not geometry loses itself alone.
TEST_F(GltfReader, BadLooksAreWarnings) {
  const auto expect = [&](const std::string& pointer, const Json& value, const std::string& message) {
    SCOPED_TRACE(pointer);
    GltfBytes bad = tests::small_gltf();
    ASSERT_TRUE(read(bad));
    const std::size_t items = scene_.item_count();
    tests::at_pointer(bad.json, pointer) = value;
    expect_warning(bad, message);
    EXPECT_EQ(scene_.item_count(), items);
  };
  expect("/meshes/0/primitives/0/attributes/NORMAL", 99, "/meshes/0/primitives/0/attributes/NORMAL: expected one of");
  expect("/meshes/0/primitives/0/material", 3, "/meshes/0/primitives/0/material: expected one of the 1 materials");
  expect("/meshes/0/primitives/0/material", -1, "/meshes/0/primitives/0/material: expected a whole number");
  expect("/materials/0/pbrMetallicRoughness/baseColorFactor", {1, 2},
         "/materials/0/pbrMetallicRoughness/baseColorFactor: expected an array of 4");
}

TEST_F(GltfReader, IndicesMayBeWholeFloats) {
  GltfBytes g = triangle_gltf();
  g.json["nodes"] = {{{"children", {1.0}}}, {{"mesh", 0.0}}};
  g.json["scenes"] = {{{"nodes", {0.0}}}};
  g.json["scene"] = 0.0;
  g.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 0.0;
  const auto report = read(g);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty());
  expect_corners(core::ItemId{0}, {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}});
}

TEST_F(GltfReader, LastRowsOfMatrices) {
  const auto with = [&](double x, double w, bool lenient = false) {
    GltfBytes g = triangle_gltf();
    g.root({{"mesh", 0}, {"matrix", {2, 0, 0, x, 0, 2, 0, 0, 0, 0, 2, 0, 4, 0, 0, w}}});
    return read(g, lenient);
  };
  const std::vector<dvec3> twice = {{6, 0, 0}, {4, 0, 4}, {4, -6, 0}}, once = {{3, 0, 0}, {2, 0, 2}, {2, -3, 0}};
  for (const double w : {1.0 + 5e-6, 1.0 - 5e-6}) {
    const auto report = with(5e-6, w);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->warnings.size(), 1u);
    expect_corners(core::ItemId{0}, twice, 1e-4);
  }
  ASSERT_TRUE(with(0.0, 2.0)) << "0 0 0 w divides by w";
  expect_corners(core::ItemId{0}, once);
  EXPECT_FALSE(with(0.1, 1.0)) << "perspective";
  ASSERT_TRUE(with(0.1, 1.0, true));
  expect_corners(core::ItemId{0}, twice);  // and the part stays in its place
}

TEST_F(GltfReader, PrimitivesWithoutPositionsAreSkipped) {
  GltfBytes g = triangle_gltf();
  g.json["meshes"][0]["primitives"].push_back({{"attributes", {{"NORMAL", 0}}}});
  g.json["meshes"][0]["primitives"].push_back({{"material", 0}});
  g.root({{"mesh", 0}});
  expect_warning(g, "2 primitives left out: they have no POSITION");
  EXPECT_EQ(scene_.item_count(), 1u);
}

TEST_F(GltfReader, IndicesOutOfRangeAreDamage) {
  GltfBytes g = tests::small_gltf();
  const auto expect = [&](const std::string& pointer, const Json& value, const std::string& message) {
    SCOPED_TRACE(pointer);
    GltfBytes bad = g;
    tests::at_pointer(bad.json, pointer) = value;
    expect_damage(bad, message);
  };
  expect("/scene", 7, "/scene: expected one of the 1 scenes, found 7");
  expect("/scenes/0/nodes/0", 99, "/scenes/0/nodes: expected one of the 6 nodes, found 99");
  expect("/scenes/0/nodes", "none", "/scenes/0/nodes: expected an array");
  expect("/nodes/1/children/0", 99, "/nodes/1/children: expected one of the 6 nodes, found 99");
  expect("/nodes/1/children/0", -1, "/nodes/1/children: expected whole numbers");
  expect("/nodes/1/scale", {1, 2}, "/nodes/1/scale: expected an array of 3 finite numbers");
  expect("/nodes/1/matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0}, "/nodes/1/matrix: expected 0 0 0 1");
  expect("/nodes/0/mesh", 99, "/nodes/0/mesh: expected one of the 3 meshes, found 99");
  expect("/nodes/0/mesh", 0.5, "/nodes/0/mesh: expected a whole number");
  expect("/meshes/0/primitives", 3, "/meshes/0/primitives: expected an array");
  expect("/meshes/0/primitives/0/attributes/POSITION", 99,
         "/meshes/0/primitives/0/attributes/POSITION: expected one of");
  expect("/meshes/0/primitives/0/attributes/POSITION", 2, "/meshes/0/primitives/0/attributes/POSITION: expected VEC3");
  expect("/meshes/0/primitives/0/indices", 0, "/meshes/0/primitives/0/indices: expected whole numbers");
  expect("/meshes/0/primitives/0/mode", 9, "/meshes/0/primitives/0/mode: expected 0 … 6");
  expect("/accessors/0/bufferView", 99, "/accessors/0/bufferView: expected one of");
  expect("/accessors/0/byteOffset", 40, "/accessors/0: expected 4 elements of 12 bytes");
  expect("/accessors/0/count", 4294967294u, "/accessors/0: expected 4294967294 elements");
  expect("/accessors/0/count", 4294967295u, "/accessors/0/count: expected less");
  expect("/accessors/0/count", 1e300, "/accessors/0/count: expected a whole number");
  expect("/accessors/0/componentType", 5124, "/accessors/0/componentType: expected");
  expect("/accessors/0/componentType", 5127, "/accessors/0/componentType: expected");
  expect("/nodes/0/mesh", -1, "/nodes/0/mesh: expected a whole number");
  expect("/nodes/1/matrix", {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, "/nodes/1/matrix: expected 0 0 0 1");
  expect("/scenes/0/nodes/1", g.json["scenes"][0]["nodes"][0],
         "/scenes/0/nodes: expected nodes without a parent, each once");
  expect("/accessors/0/type", "VEC9", "/accessors/0/type: expected");
  expect("/accessors/3/sparse/indices/bufferView", 99, "/accessors/3/sparse/indices/bufferView: expected one of");
  expect("/accessors/3/sparse/count", 1000, "/accessors/3/sparse/indices: expected 1000 elements");
  expect("/bufferViews/0/byteOffset", 9007199254740992.0, "/bufferViews/0: expected");
  expect("/bufferViews/0/byteLength", 9007199254740992.0, "/bufferViews/0: expected");
  expect("/bufferViews/0/byteStride", 4, "/accessors/0: expected 4 elements of 12 bytes, 4 apart");
  expect("/bufferViews/0/byteStride", 9007199254740992.0, "/accessors/0: expected 4 elements");
  expect("/bufferViews/0/buffer", 5, "/bufferViews/0/buffer: expected one of the 1 buffers");
}

TEST_F(GltfReader, OtherFilesAreNoGltf) {
  for (const std::string text : {"", "{", "[]", "nonsense", "glTF", "{\"asset\":{\"version\":\"1.0\"}}",
                                 "{\"asset\":{\"version\":\"2.1\",\"minVersion\":\"2.1\"}}", "{\"asset\":[]}",
                                 "{\"asset\":{\"version\":\"2.0\"},\"nodes\":{}}"}) {
    for (const bool lenient : {false, true}) {
      const auto report = read_text(text, lenient);
      ASSERT_FALSE(report) << text;
      EXPECT_EQ(report.error().message.find("model.glb: "), 0u) << report.error().message;
    }
  }
  EXPECT_TRUE(read_text("\xEF\xBB\xBF{\"asset\":{\"version\":\"2.0\"}}"));
}

TEST_F(GltfReader, CancellingTakesEverythingBack) {
  const auto bytes = tests::small_gltf().glb();
  int calls = 0;
  ASSERT_TRUE(read_gltf(bytes, "m.glb", scene_, scene_.root(), {.progress = [&](double) { return ++calls > 0; }}));
  ASSERT_GT(calls, 4);
  for (int last = 1; last < calls; ++last)  // the last call says that all is done
    for (const bool lenient : {false, true}) {
      core::Scene scene;
      int call = 0;
      const auto report = read_gltf(bytes, "m.glb", scene, scene.root(),
                                    {.lenient = lenient, .progress = [&](double) { return ++call < last; }});
      ASSERT_FALSE(report);
      EXPECT_EQ(report.error().message, kCancelled);
      EXPECT_EQ(scene.node_count(), 1u);
      EXPECT_EQ(scene.item_slots() + scene.mesh_slots() + scene.material_slots(), 0u);
    }
}

TEST_F(GltfReader, RealFile) {
  SIGHTLINE_NEED_DATA("meshes/3d_industrial_tanker.glb");
  const auto report = import_file(tests::data_path("meshes/3d_industrial_tanker.glb"), scene_, scene_.root());
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty());
  ASSERT_EQ(scene_.item_count(), 1u);
  EXPECT_EQ(scene_.mesh(scene_.mesh_of(core::ItemId{0})).indices.size(), 3u * 3720u);
  EXPECT_EQ(scene_.path(scene_.node_of(core::ItemId{0})),
            "3d_industrial_tanker.glb/Sketchfab_model/94d6c67918f74c6fbb1dbab506f21050.fbx/RootNode/Tanker/"
            "Tanker_Tanker_0");
  const core::Material& paint = scene_.material(scene_.item_material(core::ItemId{0}));
  EXPECT_EQ(paint.name, "Tanker");
  EXPECT_GT(paint.colour.y, paint.colour.z);  // green
}

}  // namespace
}  // namespace sightline::importers::gltf_reader_test
