#include "sightline/importers/gltf/internal/gltf_reader.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "sightline/importers/gltf/internal/gltf_document.h"
#include "sightline/tests/importers/gltf_bytes.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::importers {
namespace {

using core::dvec3;
using tests::GltfBytes;
using Json = nlohmann::json;

class GltfReader : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) / (std::string("sightline_gltf_") + test->name()) / "models";
    std::filesystem::remove_all(folder_.parent_path());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_.parent_path()); }

  core::Expected<ImportReport> read(std::span<const std::byte> bytes, bool lenient = false) {
    scene_ = core::Scene();
    auto report = read_gltf(bytes, folder_ / "model.glb", scene_, scene_.root(), {.lenient = lenient});
    if (report) {
      EXPECT_TRUE(scene_.commit());
    } else {
      EXPECT_EQ(scene_.node_count(), 1u);
      EXPECT_EQ(scene_.item_slots() + scene_.mesh_slots() + scene_.material_slots(), 0u);
    }
    return report;
  }
  core::Expected<ImportReport> read(const GltfBytes& file, bool lenient = false) { return read(file.glb(), lenient); }
  core::Expected<ImportReport> read_text(const std::string& text, bool lenient = false) {
    return read(std::as_bytes(std::span(text)), lenient);
  }
  /// The error of a strict read, which must fail, and the first warning of a lenient one, which must not.
  void expect_damage(const GltfBytes& file, const std::string& message) {
    const auto strict = read(file);
    ASSERT_FALSE(strict) << message;
    EXPECT_EQ(strict.error().message.find("model.glb: " + message), 0u) << strict.error().message;
    const auto lenient = read(file, true);
    ASSERT_TRUE(lenient) << lenient.error().message;
    ASSERT_FALSE(lenient->warnings.empty()) << message;
    EXPECT_EQ(lenient->warnings[0].message.find(message), 0u) << lenient->warnings[0].message;
  }

  core::NodeId find(std::string_view name) const {
    core::NodeId found;
    scene_.for_each_node(scene_.root(), [&](core::NodeId node, auto&&...) {
      if (scene_.name(node) == name) found = node;
    });
    return found;
  }
  /// World positions of an item's corners, in order.
  std::vector<dvec3> corners(core::ItemId item) const {
    const core::Affine world = scene_.state(item).world_from_item;
    const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(item));
    std::vector<dvec3> all;
    for (const std::uint32_t i : mesh.indices) all.push_back(core::transform_point(world, dvec3(mesh.positions[i])));
    return all;
  }
  void expect_corners(core::ItemId item, const std::vector<dvec3>& expected, double tolerance = 1e-6) const {
    const auto found = corners(item);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i)
      EXPECT_LE(glm::length(found[i] - expected[i]), tolerance)
          << "corner " << i << ": " << found[i].x << " " << found[i].y << " " << found[i].z;
  }

  std::filesystem::path folder_;
  core::Scene scene_;
};

/// A file with one triangle (1 0 0, 0 2 0, 0 0 3) of floats.
GltfBytes triangle_file() {
  GltfBytes g;
  g.mesh({{"attributes", {{"POSITION", g.floats({1, 0, 0, 0, 2, 0, 0, 0, 3}, "VEC3")}}}});
  return g;
}

TEST_F(GltfReader, HierarchyTransformsNamesAndAttributes) {
  GltfBytes g = triangle_file();
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
  EXPECT_EQ(scene_.path(scene_.node_of(0)), "model.glb/unit/arm/wedge");
  EXPECT_EQ(scene_.attributes(find("unit")), (core::Scene::Attributes{{"extras", "note"}}));
  const auto& attributes = scene_.attributes(find("arm"));
  ASSERT_EQ(attributes.size(), 3u);  // JSON objects have no order
  EXPECT_EQ(attributes[0], (std::pair<std::string, std::string>("open", "true")));
  EXPECT_EQ(attributes[1], (std::pair<std::string, std::string>("tag", "P-100")));
  EXPECT_EQ(attributes[2], (std::pair<std::string, std::string>("weight", "2.5")));
  EXPECT_EQ(scene_.attributes(find("unit"))[0].second, "note");
  // A quarter turn about z takes x to y and y to -x; then z up: (x, y, z) -> (x, -z, y).
  expect_corners(0, {{110, -30, 22}, {104, -30, 20}, {110, -42, 20}});
}

TEST_F(GltfReader, EveryComponentType) {
  const auto expect = [&](GltfBytes g, int positions, double scale) {
    g.mesh({{"attributes", {{"POSITION", positions}}}});
    g.root({{"mesh", 0}});
    const auto report = read(g);
    ASSERT_TRUE(report) << report.error().message;
    expect_corners(0, {{scale, 0, 0}, {0, 0, scale}, {0, -scale, 0}});
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

TEST_F(GltfReader, IndexTypesStridesStripsAndFans) {
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
  expect_corners(0, plain);
  ASSERT_TRUE(read(file(4, std::uint16_t{})));
  expect_corners(0, plain);
  ASSERT_TRUE(read(file(4, std::uint32_t{})));
  expect_corners(0, plain);
  // 0 1 2 | 2 1 0 turned | 2 0 2 empty | 2 0 3 turned: 0 3 2 … by the rule of the specification.
  ASSERT_TRUE(read(file(5, std::uint8_t{})));
  expect_corners(0, {p[0], p[1], p[2], p[1], p[0], p[2], p[0], p[3], p[2]});
  ASSERT_TRUE(read(file(6, std::uint8_t{})));
  expect_corners(0, {p[1], p[2], p[0], p[2], p[3], p[0]});
}

TEST_F(GltfReader, PointsAndLinesAreLeftOut) {
  GltfBytes g = triangle_file();
  g.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 0}});
  g.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 3}});
  g.root({{"mesh", 0}});
  const auto report = read(g);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(scene_.item_count(), 1u);
  ASSERT_EQ(report->warnings.size(), 1u);
}

/// Accessors of random types, strides, offsets and sparse changes against numbers kept beside them.
TEST_F(GltfReader, RandomAccessorsHoldTheirNumbers) {
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
    expect_corners(0, wanted, 1e-3);
    ASSERT_FALSE(HasFailure());
  }
}

TEST_F(GltfReader, InstancesShareTheirMesh) {
  GltfBytes g = triangle_file();
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
  expect_corners(0, {{6, 0, 0}, {5, 0, 2}, {5, -3, 0}});
  expect_corners(1, {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}});
  expect_corners(2, {{2, 0, 0}, {1, 0, 2}, {1, -3, 0}});
  expect_corners(3, {{0, 0, 4}, {-4, 0, 2}, {0, -6, 2}}, 1e-5);  // a quarter turn about z, twice as large
  expect_corners(4, {{-3, -3, 0}, {0, -3, -6}, {0, -12, 0}}, 1e-5);
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
    GltfBytes g = triangle_file();
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

TEST_F(GltfReader, SparseIndicesRiseBelowTheCount) {
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
  expect_corners(0, {{0, 0, 0}, {5, 0, 0}, {0, 0, 1}, {5, 0, 0}, {6, 0, 0}, {0, 0, 1}});
  const std::string where = "/accessors/0/sparse/indices: expected rising indices below 4, found ";
  expect_damage(file({4}), where + "4 at place 0");
  expect_damage(file({3, 4}), where + "4 at place 1");
  expect_damage(file({2, 2}), where + "2 at place 1");
  expect_damage(file({2, 1}), where + "1 at place 1");
}

TEST_F(GltfReader, FarFromTheOriginKeepsDetail) {
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
  expect_corners(0, {{1e7, -1e7, 1e7}, {1e7 + 2e-4, -1e7, 1e7}, {1e7, -1e7, 1e7 + 2e-4}}, 1e-8);
  expect_corners(1, {{4000000001.0, 0, 0}, {4000000000.0, 0, 1}, {4000000000.0, -1, 0}}, 1e-6);
}

TEST_F(GltfReader, MaterialsAreConvertedToSrgb) {
  GltfBytes g = triangle_file();
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
  const core::Material& paint = scene_.material(scene_.item_material(0));
  EXPECT_EQ(paint.name, "paint");
  EXPECT_NEAR(paint.colour.x, 0.5, 1e-4);
  EXPECT_EQ(paint.colour.y, 1.0f);
  EXPECT_EQ(paint.colour.z, 0.0f);
  EXPECT_EQ(paint.alpha, 0.25f);
  EXPECT_EQ(scene_.material(scene_.item_material(1)).alpha, 1.0f);  // opaque, whatever its alpha
  EXPECT_FALSE(scene_.item_material(2).valid());
}

TEST_F(GltfReader, OnlyBlendMakesMaterialsTransparent) {
  for (const auto& [mode, alpha] : {std::pair("", 1.0f), {"OPAQUE", 1.0f}, {"MASK", 1.0f}, {"BLEND", 0.0f}}) {
    SCOPED_TRACE(mode);
    GltfBytes g = triangle_file();
    g.add("materials", {{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0}}}}});
    if (*mode) g.json["materials"][0]["alphaMode"] = mode;
    g.json["meshes"][0]["primitives"][0]["material"] = 0;
    g.root({{"mesh", 0}});
    ASSERT_TRUE(read(g));
    EXPECT_EQ(scene_.material(scene_.item_material(0)).alpha, alpha);
  }
}

TEST_F(GltfReader, TexturesCountAsTheirMean) {
  // Two pixels: opaque red, and half blue without any opacity.
  GltfBytes g = tests::small_gltf();
  auto& material = g.json["materials"][0];
  material["pbrMetallicRoughness"]["baseColorFactor"] = {1.0, 1.0, 1.0, 1.0};
  ASSERT_TRUE(read(g));
  core::Material found = scene_.material(scene_.item_material(0));
  EXPECT_EQ(found.colour, core::vec3(1, 0, 0));  // blended: the second pixel does not count
  EXPECT_NEAR(found.alpha, 0.5, 1e-6);
  for (const bool said : {false, true}) {
    material.erase("alphaMode");
    if (said) material["alphaMode"] = "OPAQUE";
    ASSERT_TRUE(read(g));
    found = scene_.material(scene_.item_material(0));
    EXPECT_NEAR(found.colour.x, 0.735357, 1e-4);  // sRGB of 1/2
    EXPECT_NEAR(found.colour.z, 0.362249, 1e-4);  // of 0.2158605 / 2
    EXPECT_EQ(found.alpha, 1.0f);
  }
}

TEST_F(GltfReader, TexturesThatCannotBeReadAreWarnings) {
  const auto expect = [&](const Json& image, const std::string& part) {
    GltfBytes g = tests::small_gltf();
    g.json["images"][0] = image;
    g.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {0.0, 1.0, 0.0, 1.0};
    const auto report = read(g);
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_EQ(report->warnings.size(), 1u) << part;
    EXPECT_NE(report->warnings[0].message.find(part), std::string::npos) << report->warnings[0].message;
    EXPECT_EQ(scene_.material(scene_.item_material(0)).colour, core::vec3(0, 1, 0));
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

TEST_F(GltfReader, BuffersBesideTheModel) {
  GltfBytes g = triangle_file();
  g.root({{"mesh", 0}});
  const auto* data = reinterpret_cast<const char*>(g.binary.data());
  std::filesystem::create_directories(folder_ / "parts");
  std::ofstream(folder_ / "parts" / "a b.bin", std::ios::binary).write(data, std::streamsize(g.binary.size()));
  std::ofstream(folder_.parent_path() / "secret.bin", std::ios::binary).write(data, std::streamsize(g.binary.size()));
  const auto near = read_text(g.gltf("parts/a%20b.bin"));
  ASSERT_TRUE(near) << near.error().message;
  EXPECT_EQ(near->bytes, g.gltf("parts/a%20b.bin").size() + g.binary.size());
  expect_corners(0, {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}});
  ASSERT_TRUE(read_text(g.gltf("data:application/octet-stream;base64," + tests::base64(g.binary))));
  expect_corners(0, {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}});
  for (const std::string bad : {"../secret.bin", "%2e%2e/secret.bin", "/etc/passwd", "file:///etc/passwd",
                                "missing.bin", "", "data:,xyz", "data:x;base64,(/)"}) {
    const auto strict = read_text(g.gltf(bad));
    ASSERT_FALSE(strict) << bad;
    EXPECT_EQ(strict.error().message.find("model.glb: /buffers/0"), 0u) << strict.error().message;
    const auto lenient = read_text(g.gltf(bad), true);
    ASSERT_TRUE(lenient) << lenient.error().message;
    EXPECT_EQ(scene_.item_count(), 0u);
    EXPECT_EQ(lenient->warnings.size(), 1u);
  }
}

TEST_F(GltfReader, RequiredExtensions) {
  GltfBytes g = triangle_file();
  g.root({{"mesh", 0}});
  g.json["extensionsRequired"] = {"KHR_mesh_quantization", "KHR_materials_unlit", "EXT_mesh_gpu_instancing",
                                  "EXT_texture_webp"};
  EXPECT_TRUE(read(g));
  g.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  expect_damage(g, "/extensionsRequired: expected extensions that can be read, found KHR_draco_mesh_compression");
  g.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  expect_damage(g, "/extensionsRequired: expected extensions that can be read, found EXT_meshopt_compression");
}

TEST_F(GltfReader, DefaultSceneAndOthers) {
  GltfBytes g = triangle_file();
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
  GltfBytes g = triangle_file();
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

TEST_F(GltfReader, IndicesOutOfRangeAreDamage) {
  GltfBytes g = tests::small_gltf();
  const auto expect = [&](const std::string& pointer, const Json& value, const std::string& message) {
    SCOPED_TRACE(pointer);
    GltfBytes bad = g;
    bad.json[Json::json_pointer(pointer)] = value;
    expect_damage(bad, message);
  };
  expect("/scene", 7, "/scene: expected one of the 1 scenes, found 7");
  expect("/scenes/0/nodes/0", 99, "/scenes/0/nodes: expected one of the 5 nodes, found 99");
  expect("/scenes/0/nodes", "none", "/scenes/0/nodes: expected an array");
  expect("/nodes/1/children/0", 99, "/nodes/1/children: expected one of the 5 nodes, found 99");
  expect("/nodes/1/children/0", -1, "/nodes/1/children: expected whole numbers");
  expect("/nodes/1/scale", {1, 2}, "/nodes/1/scale: expected an array of 3 finite numbers");
  expect("/nodes/1/matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2}, "/nodes/1/matrix: expected 0 0 0 1");
  expect("/nodes/0/mesh", 99, "/nodes/0/mesh: expected one of the 2 meshes, found 99");
  expect("/nodes/0/mesh", 0.5, "/nodes/0/mesh: expected a whole number");
  expect("/meshes/0/primitives", 3, "/meshes/0/primitives: expected an array");
  expect("/meshes/0/primitives/0/attributes/POSITION", 99,
         "/meshes/0/primitives/0/attributes/POSITION: expected one of");
  expect("/meshes/0/primitives/0/attributes/POSITION", 2, "/meshes/0/primitives/0/attributes/POSITION: expected VEC3");
  expect("/meshes/0/primitives/0/attributes/NORMAL", 99, "/meshes/0/primitives/0/attributes/NORMAL: expected one of");
  expect("/meshes/0/primitives/0/indices", 0, "/meshes/0/primitives/0/indices: expected whole numbers");
  expect("/meshes/0/primitives/0/mode", 9, "/meshes/0/primitives/0/mode: expected 0 … 6");
  expect("/meshes/0/primitives/0/material", 3, "/meshes/0/primitives/0/material: expected one of the 1 materials");
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
  expect("/materials/0/pbrMetallicRoughness/baseColorFactor", {1, 2},
         "/materials/0/pbrMetallicRoughness/baseColorFactor:");
}

TEST_F(GltfReader, IndicesBeyondTheVerticesCostTheirTriangles) {
  GltfBytes g = triangle_file();
  g.json["meshes"][0]["primitives"][0]["indices"] =
      g.accessor<std::uint16_t>({0, 1, 2, 0, 1, 3, 0, 65535, 2}, "SCALAR");
  g.root({{"mesh", 0}});
  expect_damage(g, "/meshes/0/primitives/0/indices: expected indices below the 3 vertices, found 2 triangles beyond");
  EXPECT_EQ(corners(0).size(), 3u);
}

TEST_F(GltfReader, GeometryThatIsNotFiniteIsDropped) {
  GltfBytes g;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  g.mesh({{"attributes", {{"POSITION", g.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, nan, 0, 0, 0, 1, 0}, "VEC3")}}}});
  g.root({{"mesh", 0}});
  const auto report = read(g);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->warnings.size(), 1u);
  EXPECT_EQ(corners(0).size(), 3u);
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
  EXPECT_EQ(scene_.mesh(scene_.mesh_of(0)).indices.size(), 3u * 3720u);
  EXPECT_EQ(scene_.path(scene_.node_of(0)),
            "3d_industrial_tanker.glb/Sketchfab_model/94d6c67918f74c6fbb1dbab506f21050.fbx/RootNode/Tanker/"
            "Tanker_Tanker_0");
  const core::Material& paint = scene_.material(scene_.item_material(0));
  EXPECT_EQ(paint.name, "Tanker");
  EXPECT_GT(paint.colour.y, paint.colour.z);  // green
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

TEST_F(GltfReader, ImagesThatClaimMoreThanTheyHold) {
  const std::vector<std::uint8_t> pixel = {0x78, 1, 1, 5, 0, 250, 255, 0, 1, 2, 3, 4, 0, 0, 0, 0};
  const std::vector<std::uint8_t> zeros = swelling_zeros();
  // stb_image alone reads the first one, takes 2 GiB for the second one, and does not return from the third one.
  for (const std::string& image : {png_of_one_pixel({{std::uint32_t(zeros.size()), zeros}}),
                                   png_of_one_pixel({{0x7abfe010u, pixel}}),
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

TEST_F(GltfReader, DarkAndInvisibleTextures) {
  GltfBytes g = tests::small_gltf();
  auto& material = g.json["materials"][0];
  material["pbrMetallicRoughness"]["baseColorFactor"] = {1.0, 1.0, 1.0, 1.0};
  g.json["images"][0] = {{"uri", one_pixel(2, 10, 11, 0)}};
  const auto report = read(g);  // blended: nothing of the texture is seen
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->warnings.empty()) << report->warnings[0].message;
  EXPECT_EQ(scene_.material(scene_.item_material(0)).colour, core::vec3(1.0f));
  EXPECT_EQ(scene_.material(scene_.item_material(0)).alpha, 0.0f);
  material["alphaMode"] = "OPAQUE";
  ASSERT_TRUE(read(g));
  const core::vec3 dark = scene_.material(scene_.item_material(0)).colour;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(dark[i], core::vec3(2, 10, 11)[i] / 255.0f, 1e-5f);
}

TEST_F(GltfReader, ElementsEndWithinTheirView) {
  const auto file = [](std::size_t length, std::size_t offset, std::size_t count) {
    GltfBytes g = triangle_file();
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

TEST_F(GltfReader, BothAlphabetsOfBase64) {
  GltfBytes g;
  const std::vector<std::uint8_t> bytes = {251, 239, 190, 255, 255, 255, 0, 0, 0};
  g.mesh({{"attributes", {{"POSITION", g.accessor(bytes, "VEC3")}}}});
  g.root({{"mesh", 0}});
  std::string text = tests::base64(g.binary);
  ASSERT_EQ(text.substr(0, 8), "++++////");
  ASSERT_TRUE(read_text(g.gltf("data:application/octet-stream;base64," + text)));
  const auto standard = corners(0);
  ASSERT_EQ(standard.size(), 3u);
  EXPECT_NEAR(standard[0].x, 251, 1e-5);
  text.replace(0, 8, "----____");
  ASSERT_TRUE(read_text(g.gltf("data:application/octet-stream;base64," + text)));
  EXPECT_EQ(corners(0), standard);
}

TEST_F(GltfReader, ChunksOfBinaryFiles) {
  GltfBytes g = triangle_file();
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
    expect_corners(0, {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}});
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

TEST_F(GltfReader, PercentSigns) {
  EXPECT_EQ(percent_decoded("a%20b%"), "a b%");
  EXPECT_EQ(percent_decoded("%41"), "A");
  EXPECT_EQ(percent_decoded("x%4"), "x%4");
  EXPECT_EQ(percent_decoded("%4g%g4%zz"), "%4g%g4%zz");
}

TEST_F(GltfReader, PrimitivesTakeTheirVerticesOfALongList) {
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
    const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(0));
    ASSERT_EQ(mesh.positions.size(), 3u);
    for (std::size_t c = 0; c < 3; ++c) {
      const double i = indices[c];
      EXPECT_LT(glm::distance(corners(0)[c], dvec3(i, 0, i * i)), 1e-4);
      EXPECT_EQ(mesh.normals[mesh.indices[c]], core::vec3(float(i), 0, 1));
    }
    g.json["accessors"][1]["count"] = 39;
    expect_damage(g, "/meshes/0/primitives/0/attributes/NORMAL: expected 40 normals, found 39");
    g.json["accessors"][1]["count"] = 40;
  }
}

TEST_F(GltfReader, StripsAreStitchedWithEmptyTriangles) {
  for (const std::vector<std::uint8_t>& strip :
       {std::vector<std::uint8_t>{0, 0, 1, 2}, {0, 1, 2, 2}, {0, 1, 0}, {0, 1, 1}}) {
    GltfBytes g = triangle_file();
    auto& primitive = g.json["meshes"][0]["primitives"][0];
    primitive["mode"] = 5, primitive["indices"] = g.accessor(strip, "SCALAR");
    g.root({{"mesh", 0}});
    ASSERT_TRUE(read(g));
    EXPECT_EQ(scene_.mesh(scene_.mesh_of(0)).indices.size(), strip.size() == 4 ? 3u : 0u);
  }
  GltfBytes g = triangle_file();
  g.json["meshes"][0]["primitives"][0]["indices"] = g.accessor<std::int8_t>({0, 1, -1}, "SCALAR");
  g.root({{"mesh", 0}});
  expect_damage(g, "/meshes/0/primitives/0/indices: expected indices below the 3 vertices, found 1 triangles beyond");
}

TEST_F(GltfReader, InstancesByTheThousand) {
  GltfBytes g = triangle_file();
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

}  // namespace
}  // namespace sightline::importers
