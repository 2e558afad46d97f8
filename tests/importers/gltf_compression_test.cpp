// Compressed meshes, made by the libraries' own encoders: what comes out is what went in, and damaged streams are
// refused. Builds without a library refuse its files by the extension's name.
#include "sightline/importers/gltf/internal/gltf_compression.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#ifdef SIGHTLINE_HAVE_MESHOPT
#include <meshoptimizer.h>
#endif
#ifdef SIGHTLINE_HAVE_DRACO
#include <draco/compression/expert_encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#endif

#include "sightline/tests/importers/gltf_reading.h"
#include "sightline/tests/importers/hostile.h"
#include "sightline/tests/support/effort.h"
#include "sightline/tests/support/json_pointer.h"

namespace sightline::importers::gltf_compression_test {
namespace {

using core::dvec3;
using tests::GltfBytes;
using Bytes = std::vector<std::byte>;
using Json = json::Value;

/// A bent sheet with normals and colours.
struct Sheet {
  std::vector<float> positions, normals;
  std::vector<std::uint8_t> colours;  // four bytes a vertex
  std::vector<std::uint32_t> indices;

  Sheet(std::size_t cells, std::mt19937& random, bool coloured = true) {
    const auto n = std::uint32_t(cells);
    for (std::uint32_t y = 0; y <= n; ++y)
      for (std::uint32_t x = 0; x <= n; ++x) {
        const float z = float(random() % 1000) / 1000.0f;
        positions.insert(positions.end(), {float(x), float(y) * 0.7f, z});
        const dvec3 normal = glm::normalize(dvec3(0.1 * x, -0.2 * y, 1.0));
        normals.insert(normals.end(), {float(normal.x), float(normal.y), float(normal.z)});
        const auto shade = std::uint8_t(coloured && x > n / 2 ? 255 : 0);
        colours.insert(colours.end(), {shade, 255, 0, 255});
      }
    for (std::uint32_t y = 0; y < n; ++y)
      for (std::uint32_t x = 0; x < n; ++x) {
        const std::uint32_t a = y * (n + 1) + x, b = a + 1, c = a + n + 1, d = c + 1;
        indices.insert(indices.end(), {a, b, c, c, b, d});
      }
  }
  std::size_t vertices() const { return positions.size() / 3; }
};

class GltfCompression : public tests::GltfReading {
 protected:
  /// By the place in the sheet, whose heights are rounded.
  static bool in_grid(const std::array<double, 3>& a, const std::array<double, 3>& b) {
    const long x = std::lround(20 * a[0]), other = std::lround(20 * b[0]);
    return x != other ? x < other : std::lround(20 * a[2]) < std::lround(20 * b[2]);
  }
  /// Triangles of all items in the world, each from its least corner on, sorted. With colours of their items.
  std::vector<std::array<double, 12>> triangles() const {
    std::vector<std::array<double, 12>> all;
    for (core::ItemId item{0}; to_index(item) < scene_.item_slots(); ++item) {
      const auto corner = corners(item);
      const core::MaterialId material = scene_.item_material(item);
      const core::vec3 colour = material.valid() ? scene_.material(material).colour : core::vec3(0.5f);
      for (std::size_t t = 0; t + 2 < corner.size(); t += 3) {
        std::array<std::array<double, 3>, 3> c;
        for (std::size_t k = 0; k < 3; ++k) c[k] = {corner[t + k].x, corner[t + k].y, corner[t + k].z};
        std::rotate(c.begin(), std::min_element(c.begin(), c.end(), in_grid), c.end());
        all.push_back({c[0][0], c[0][1], c[0][2], c[1][0], c[1][1], c[1][2], c[2][0], c[2][1], c[2][2],
                       double(colour.x), double(colour.y), double(colour.z)});
      }
    }
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
      for (std::size_t k = 0; k < 9; k += 3)
        for (const std::size_t i : {k, k + 2})
          if (std::lround(20 * a[i]) != std::lround(20 * b[i])) return a[i] < b[i];
      return false;
    });
    return all;
  }
  static GltfBytes plain(const Sheet& sheet) {
    GltfBytes g;
    g.mesh({{"attributes",
             {{"POSITION", g.floats(sheet.positions, "VEC3")},
              {"NORMAL", g.floats(sheet.normals, "VEC3")},
              {"COLOR_0", g.accessor(sheet.colours, "VEC4", true)}}},
            {"indices", g.accessor(sheet.indices, "SCALAR")}});
    g.root({{"mesh", 0}});
    return g;
  }
  /// The file reads as the same sheet uncompressed does, up to `tolerance`.
  void expect_as_plain(const GltfBytes& file, const Sheet& sheet, double tolerance) {
    ASSERT_TRUE(read(plain(sheet)));
    const auto wanted = triangles();
    ASSERT_EQ(wanted.size(), sheet.indices.size() / 3);
    const auto report = read(file);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->warnings.empty());
    const auto found = triangles();
    ASSERT_EQ(found.size(), wanted.size());
    for (std::size_t t = 0; t < found.size(); ++t)
      for (std::size_t k = 0; k < 12; ++k) ASSERT_NEAR(found[t][k], wanted[t][k], tolerance) << t;
  }
  /// A file whose streams are cut or changed is never a crash, and bounded in memory.
  static void survive(const GltfBytes& file) {
    hostile::Target target = hostile::target_of("glb");
    target.memory_factor *= 64;  // the libraries' own memory comes on top
    tests::survives_both(target, hostile::one_file("model.glb", hostile::text_of(file.glb())), "model.glb");
  }
};

#ifdef SIGHTLINE_HAVE_MESHOPT

/// A buffer view of a stream, whose own bytes lie in a buffer that holds nothing.
int meshopt_view(GltfBytes& g, const std::vector<unsigned char>& stream, std::size_t count, std::size_t stride,
                 const std::string& mode, const std::string& filter = "NONE") {
  const int packed = g.view(stream.data(), stream.size());
  const Json where = g.json["bufferViews"][std::size_t(packed)];
  g.json["bufferViews"].erase(std::size_t(packed));
  Json view = {{"buffer", 1},
               {"byteLength", count * stride},
               {"extensions",
                {{std::string(kMeshopt),
                  {{"buffer", 0},
                   {"byteOffset", where["byteOffset"]},
                   {"byteLength", where["byteLength"]},
                   {"byteStride", stride},
                   {"count", count},
                   {"mode", mode},
                   {"filter", filter}}}}}};
  if (mode == "ATTRIBUTES") view["byteStride"] = stride;
  return g.add("bufferViews", view);
}

std::vector<unsigned char> encoded_vertices(const void* data, std::size_t count, std::size_t stride) {
  std::vector<unsigned char> stream(meshopt_encodeVertexBufferBound(count, stride));
  stream.resize(meshopt_encodeVertexBuffer(stream.data(), stream.size(), data, count, stride));
  return stream;
}

struct MeshoptFile {
  GltfBytes g;
  std::size_t stream = 0, stream_bytes = 0;  // of the positions, in the binary part
};

MeshoptFile meshopt_file(const Sheet& sheet, const std::string& index_mode, bool filters) {
  MeshoptFile made;
  GltfBytes& g = made.g;
  const std::size_t n = sheet.vertices();
  const auto accessor = [&](int view, int type, std::size_t count, const char* shape, bool normalized = false) {
    return g.add(
        "accessors",
        {{"bufferView", view}, {"componentType", type}, {"count", count}, {"type", shape}, {"normalized", normalized}});
  };
  std::vector<float> positions = sheet.positions;
  if (filters) {
    std::vector<std::uint32_t> encoded(positions.size());
    meshopt_encodeFilterExp(encoded.data(), n, 12, 20, positions.data());
    std::memcpy(positions.data(), encoded.data(), encoded.size() * 4);
  }
  const auto stream = encoded_vertices(positions.data(), n, 12);
  made.stream = (g.binary.size() + 3) / 4 * 4, made.stream_bytes = stream.size();
  const int position =
      accessor(meshopt_view(g, stream, n, 12, "ATTRIBUTES", filters ? "EXPONENTIAL" : "NONE"), 5126, n, "VEC3");
  int normal = 0;
  if (filters) {
    std::vector<float> four;
    for (std::size_t v = 0; v < n; ++v)
      four.insert(four.end(), {sheet.normals[3 * v], sheet.normals[3 * v + 1], sheet.normals[3 * v + 2], 0.0f});
    std::vector<std::int8_t> oct(4 * n);
    meshopt_encodeFilterOct(oct.data(), n, 4, 8, four.data());
    normal = accessor(meshopt_view(g, encoded_vertices(oct.data(), n, 4), n, 4, "ATTRIBUTES", "OCTAHEDRAL"), 5120, n,
                      "VEC3", true);
  } else {
    normal =
        accessor(meshopt_view(g, encoded_vertices(sheet.normals.data(), n, 12), n, 12, "ATTRIBUTES"), 5126, n, "VEC3");
  }
  const int colour = accessor(meshopt_view(g, encoded_vertices(sheet.colours.data(), n, 4), n, 4, "ATTRIBUTES"), 5121,
                              n, "VEC4", true);
  const std::size_t count = sheet.indices.size();
  std::vector<unsigned char> indices(
      std::max(meshopt_encodeIndexBufferBound(count, n), meshopt_encodeIndexSequenceBound(count, n)));
  indices.resize(index_mode == "TRIANGLES"
                     ? meshopt_encodeIndexBuffer(indices.data(), indices.size(), sheet.indices.data(), count)
                     : meshopt_encodeIndexSequence(indices.data(), indices.size(), sheet.indices.data(), count));
  const bool small = n < 65536;
  const int index =
      accessor(meshopt_view(g, indices, count, small ? 2 : 4, index_mode), small ? 5123 : 5125, count, "SCALAR");
  g.mesh({{"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"COLOR_0", colour}}}, {"indices", index}});
  g.root({{"mesh", 0}});
  g.add("buffers", {{"byteLength", 1u << 30}, {"extensions", {{std::string(kMeshopt), {{"fallback", true}}}}}});
  g.json["extensionsUsed"] = g.json["extensionsRequired"] = Json::array({kMeshopt});
  return made;
}

TEST_F(GltfCompression, MeshoptComesBack) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const Sheet sheet(seed == 11 ? 260 : 1 + random() % 30, random);
    const bool filters = seed % 2 == 1;
    const MeshoptFile file = meshopt_file(sheet, seed % 3 ? "TRIANGLES" : "INDICES", filters);
    expect_as_plain(file.g, sheet, filters ? 1e-3 : 1e-6);
    const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(core::ItemId{0}));
    ASSERT_FALSE(mesh.normals.empty());
    for (const core::vec3& n : mesh.normals) EXPECT_NEAR(glm::length(n), 1.0f, 0.02f);
    EXPECT_EQ(scene_.material_slots(), sheet.vertices() > 4 ? scene_.item_count() : scene_.material_slots());
  }
}

/// Rotations of instances, which the quaternion filter is for.
TEST_F(GltfCompression, MeshoptTurnsInstances) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  const std::size_t count = 60;
  std::vector<float> turns;
  for (std::size_t i = 0; i < count; ++i) {
    float q[4], length = 0.0f;
    for (float& x : q) x = normal(random), length += x * x;
    for (const float x : q) turns.push_back(x / std::sqrt(length));
  }
  std::vector<std::int16_t> encoded(4 * count);
  meshopt_encodeFilterQuat(encoded.data(), count, 8, 16, turns.data());
  GltfBytes packed = tests::triangle_gltf(), plain = packed;
  const int rotation =
      packed.add("accessors", {{"bufferView", meshopt_view(packed, encoded_vertices(encoded.data(), count, 8), count, 8,
                                                           "ATTRIBUTES", "QUATERNION")},
                               {"componentType", 5122},
                               {"count", count},
                               {"type", "VEC4"},
                               {"normalized", true}});
  const auto with = [](GltfBytes& g, int rotations) {
    g.add("buffers", {{"byteLength", 480}, {"extensions", {{std::string(kMeshopt), {{"fallback", true}}}}}});
    g.root({{"mesh", 0}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"ROTATION", rotations}}}}}}}});
  };
  with(packed, rotation), with(plain, plain.floats(turns, "VEC4"));
  ASSERT_TRUE(read(plain));
  std::vector<std::vector<dvec3>> wanted;
  for (core::ItemId item{0}; to_index(item) < count; ++item) wanted.push_back(corners(item));
  const auto report = read(packed);
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(scene_.item_count(), count);
  for (core::ItemId item{0}; to_index(item) < count; ++item) expect_corners(item, wanted[to_index(item)], 1e-3);
}

TEST_F(GltfCompression, MeshoptStreamsThatAreCut) {
  std::mt19937 random(1);
  const Sheet sheet(5, random);
  const MeshoptFile whole = meshopt_file(sheet, "TRIANGLES", true);
  ASSERT_TRUE(read(whole.g));
  auto& view = whole.g.json["bufferViews"][0]["extensions"][std::string(kMeshopt)];
  const std::string where = "/bufferViews/0/extensions/EXT_meshopt_compression: ";
  for (std::size_t size = 0; size < whole.stream_bytes; ++size) {
    GltfBytes cut = whole.g;
    cut.json["bufferViews"][0]["extensions"][std::string(kMeshopt)]["byteLength"] = size;
    expect_damage(cut, where + "EXT_meshopt_compression: expected a stream");
    ASSERT_FALSE(testing::Test::HasFailure()) << size;
  }
  const auto expect = [&](const std::string& key, const Json& value, const std::string& message) {
    GltfBytes bad = whole.g;
    bad.json["bufferViews"][0]["extensions"][std::string(kMeshopt)][key] = value;
    expect_damage(bad, message);
  };
  expect("byteLength", view["byteLength"].get<std::size_t>() + 4, where);
  expect("byteLength", 1e9, where + "expected 1000000000 bytes");
  expect("count", view["count"].get<std::size_t>() + 1, where + "expected");
  expect("count", 4294967295u, where + "expected");
  expect("byteStride", 0, where + "expected");
  expect("byteStride", 300, where + "expected");
  expect("mode", "POINTS", where + "EXT_meshopt_compression: expected the mode");
  expect("mode", "TRIANGLES", where + "EXT_meshopt_compression: expected a byteStride of 2 or 4");
  expect("filter", "SMOOTH", where + "EXT_meshopt_compression: expected the filter");
  expect("filter", "OCTAHEDRAL", where + "EXT_meshopt_compression: expected attributes of the filter's size");
  expect("filter", "QUATERNION", where + "EXT_meshopt_compression: expected attributes of the filter's size");
  expect("buffer", 7, where.substr(0, where.size() - 2) + "/buffer: expected one of");
}

TEST_F(GltfCompression, MeshoptHostileBytes) {
  for (unsigned seed = 0; seed < unsigned(tests::repeated(2000)); ++seed) {
    std::mt19937 random(seed);
    const Sheet sheet(1 + random() % 8, random);
    GltfBytes file = meshopt_file(sheet, random() % 2 ? "TRIANGLES" : "INDICES", random() % 2).g;
    for (std::size_t t = 0, n = 1 + random() % 6; t < n; ++t)
      file.binary[random() % file.binary.size()] = std::byte(random());
    survive(file);
    ASSERT_FALSE(testing::Test::HasFailure()) << "seed " << seed;
  }
  // What a few bytes claim to hold.
  std::mt19937 random(1);
  GltfBytes swollen = meshopt_file(Sheet(3, random), "TRIANGLES", false).g;
  auto& view = swollen.json["bufferViews"][0];
  view["byteLength"] = 12'000'000'000u, view["extensions"][std::string(kMeshopt)]["count"] = 1'000'000'000u;
  survive(swollen);
  expect_damage(swollen, "/bufferViews/0/extensions/EXT_meshopt_compression: holds more than 64 times");
}

#endif

#ifdef SIGHTLINE_HAVE_DRACO

Bytes draco_stream(const Sheet& sheet, int speed, int bits, bool edgebreaker) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(int(sheet.indices.size() / 3));
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int normal = builder.AddAttribute(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32);
  const int colour = builder.AddAttribute(draco::GeometryAttribute::COLOR, 4, draco::DT_UINT8);
  for (std::uint32_t f = 0; f < sheet.indices.size() / 3; ++f) {
    const std::uint32_t* c = &sheet.indices[3 * f];
    const draco::FaceIndex face(f);
    builder.SetAttributeValuesForFace(position, face, &sheet.positions[3 * c[0]], &sheet.positions[3 * c[1]],
                                      &sheet.positions[3 * c[2]]);
    builder.SetAttributeValuesForFace(normal, face, &sheet.normals[3 * c[0]], &sheet.normals[3 * c[1]],
                                      &sheet.normals[3 * c[2]]);
    builder.SetAttributeValuesForFace(colour, face, &sheet.colours[4 * c[0]], &sheet.colours[4 * c[1]],
                                      &sheet.colours[4 * c[2]]);
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::ExpertEncoder encoder(*mesh);
  encoder.SetEncodingMethod(edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING : draco::MESH_SEQUENTIAL_ENCODING);
  encoder.SetSpeedOptions(speed, speed);
  if (bits > 0) {
    encoder.SetAttributeQuantization(position, bits);
    encoder.SetAttributeQuantization(normal, 8);
  }
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) return {};
  const auto* bytes = reinterpret_cast<const std::byte*>(buffer.data());
  return {bytes, bytes + buffer.size()};
}

GltfBytes draco_file(const Sheet& sheet, const Bytes& stream) {
  GltfBytes g;
  const int view = g.view(stream.data(), stream.size());
  const auto accessor = [&](int type, std::size_t count, const char* shape, bool normalized = false) {
    return g.add("accessors", {{"componentType", type}, {"count", count}, {"type", shape}, {"normalized", normalized}});
  };
  const std::size_t n = sheet.vertices();
  const int position = accessor(5126, n, "VEC3"), normal = accessor(5126, n, "VEC3"),
            colour = accessor(5121, n, "VEC4", true), index = accessor(5125, sheet.indices.size(), "SCALAR");
  g.mesh({{"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"COLOR_0", colour}}},
          {"indices", index},
          {"extensions",
           {{std::string(kDraco),
             {{"bufferView", view}, {"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"COLOR_0", 2}}}}}}}});
  g.root({{"mesh", 0}});
  g.json["extensionsUsed"] = g.json["extensionsRequired"] = Json::array({kDraco});
  return g;
}

TEST_F(GltfCompression, DracoComesBack) {
  for (unsigned seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const Sheet sheet(2 + random() % 30, random);
    const int bits = seed % 2 ? 16 : 0;
    const Bytes stream = draco_stream(sheet, int(random() % 11), bits, seed % 3 != 0);
    ASSERT_FALSE(stream.empty());
    GltfBytes file = draco_file(sheet, stream);
    expect_as_plain(file, sheet, bits ? 1e-3 : 1e-6);
    file.json["meshes"][0]["primitives"][0].erase("indices");  // as some writers leave them to Draco
    expect_as_plain(file, sheet, bits ? 1e-3 : 1e-6);
  }
}

TEST_F(GltfCompression, DracoMeshesAreReadOnce) {
  std::mt19937 random(3);
  const Sheet sheet(4, random, false);
  GltfBytes file = draco_file(sheet, draco_stream(sheet, 5, 0, true));
  file.root({{"mesh", 0}, {"translation", {0, 0, 9}}});
  ASSERT_TRUE(read(file));
  EXPECT_EQ(scene_.item_count(), 2u);
  EXPECT_EQ(scene_.mesh_slots(), 1u);
  // Accessors of one mesh cannot be those of another.
  GltfBytes twice = draco_file(sheet, draco_stream(sheet, 5, 0, true));
  const Bytes other = draco_stream(sheet, 7, 0, false);
  Json second = twice.json["meshes"][0]["primitives"][0];
  second["extensions"][std::string(kDraco)]["bufferView"] = twice.view(other.data(), other.size());
  twice.json["meshes"][0]["primitives"].push_back(second);
  expect_damage(twice, "/meshes/0/primitives/1/attributes/COLOR_0: expected accessor 2 to be that of one");
}

TEST_F(GltfCompression, DracoStreamsThatAreCut) {
  std::mt19937 random(1);
  const Sheet sheet(3, random);
  const std::string where = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
  for (const bool edgebreaker : {false, true}) {
    const Bytes stream = draco_stream(sheet, 3, 11, edgebreaker);
    const GltfBytes whole = draco_file(sheet, stream);
    ASSERT_TRUE(read(whole));
    // Some decoders do not miss the last bytes, which then were not needed.
    const auto triangles_of_whole = triangles();
    for (std::size_t size = 0; size < stream.size(); ++size) {
      GltfBytes cut = whole;
      cut.json["bufferViews"][0]["byteLength"] = size;
      if (size + 8 < stream.size()) {
        expect_damage(cut, where);
      } else if (read(cut)) {
        EXPECT_EQ(triangles(), triangles_of_whole);
      }
      ASSERT_FALSE(testing::Test::HasFailure()) << size << " of " << stream.size();
    }
  }
  const GltfBytes whole = draco_file(sheet, draco_stream(sheet, 3, 0, true));
  const auto expect = [&](const std::string& pointer, const Json& value, const std::string& message) {
    GltfBytes bad = whole;
    tests::at_pointer(bad.json["meshes"][0]["primitives"][0], pointer) = value;
    expect_damage(bad, message);
  };
  const std::string extension = "/extensions/KHR_draco_mesh_compression";
  expect("/mode", 5, where + ": expected triangles (mode 4), found mode 5");
  expect(extension + "/bufferView", 9, where + "/bufferView: expected one of");
  expect(extension + "/attributes", 3, where + "/attributes: expected an object");
  expect(extension + "/attributes/POSITION", 7, where + ": KHR_draco_mesh_compression: expected an attribute");
  expect(extension + "/attributes/POSITION", 2, where + ": KHR_draco_mesh_compression: attribute 2: expected 3");
}

TEST_F(GltfCompression, DracoHostileBytes) {
  for (unsigned seed = 0; seed < unsigned(tests::repeated(2000)); ++seed) {
    std::mt19937 random(seed);
    const Sheet sheet(1 + random() % 8, random);
    Bytes stream = draco_stream(sheet, int(random() % 11), random() % 2 ? 10 : 0, random() % 2);
    for (std::size_t t = 0, n = 1 + random() % 4; t < n; ++t) stream[random() % stream.size()] = std::byte(random());
    survive(draco_file(sheet, stream));
    ASSERT_FALSE(testing::Test::HasFailure()) << "seed " << seed;
  }
}

#endif

/// In a build without the library. Also where the uncompressed twin is there: then it is read.
TEST_F(GltfCompression, AbsentLibrariesAreNamed) {
  for (const std::string_view extension : {kMeshopt, kDraco}) {
    if (can_decompress(extension)) continue;
    GltfBytes g = tests::triangle_gltf();
    g.root({{"mesh", 0}});
    g.json["extensionsRequired"] = Json::array({extension});
    expect_damage(g, "/extensionsRequired: " + std::string(extension) + " cannot be read: this build is without");
    EXPECT_EQ(scene_.item_count(), 1u);
    g.json.erase("extensionsRequired");
    if (extension == kMeshopt) {
      g.json["bufferViews"][0]["extensions"][std::string(kMeshopt)] = {
          {"buffer", 0}, {"byteLength", 3}, {"byteStride", 12}, {"count", 3}, {"mode", "ATTRIBUTES"}};
    } else {
      g.json["meshes"][0]["primitives"][0]["indices"] = g.accessor<std::uint8_t>({0, 1, 2}, "SCALAR");
      g.json["meshes"][0]["primitives"][0]["extensions"][std::string(kDraco)] = {{"bufferView", 0},
                                                                                 {"attributes", {{"POSITION", 0}}}};
    }
    ASSERT_TRUE(read(g));
    EXPECT_EQ(scene_.item_count(), 1u);
    if (extension == kMeshopt) {
      g.add("buffers", {{"byteLength", 36}, {"extensions", {{std::string(kMeshopt), {{"fallback", true}}}}}});
      g.json["bufferViews"][0]["buffer"] = 1;
    } else {
      g.json["accessors"][0].erase("bufferView");
    }
    const auto report = read(g);
    ASSERT_FALSE(report);
    EXPECT_NE(report.error().message.find(extension), std::string::npos) << report.error().message;
  }
}

}  // namespace
}  // namespace sightline::importers::gltf_compression_test
