// Scenes written as 3D Tiles: the tileset by the specification's rules, and what each tile shows beside the scene.
#include "sightline/importers/tiles/tiles_writer.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/importers/gltf/internal/meshopt_encoding.h"
#include "sightline/importers/import.h"
#include "sightline/importers/internal/file_bytes.h"
#include "sightline/importers/internal/tessellated.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/lod/stored_levels.h"
#include "sightline/tests/importers/tiles_structure.h"
#include "sightline/tests/importers/triangle_distance.h"
#include "sightline/tests/lod/mesh_samples.h"

namespace sightline::importers::tiles_writer_test {
namespace {

namespace fs = std::filesystem;
using core::Affine;
using core::dmat3;
using core::dvec3;
using tests::TilesStructure;
using tests::TileTriangles;
using Json = json::Value;
using Triangles = std::vector<std::array<dvec3, 3>>;

std::string text_of(const fs::path& file) {
  const auto bytes = read_file_bytes(file).value();
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

double area(const Triangles& triangles) {
  double sum = 0.0;
  for (const auto& t : triangles) sum += 0.5 * glm::length(glm::cross(t[1] - t[0], t[2] - t[0]));
  return sum;
}

double volume(const Triangles& triangles) {
  double sum = 0.0;
  const dvec3 o = triangles[0][0];
  for (const auto& t : triangles) sum += glm::dot(t[0] - o, glm::cross(t[1] - o, t[2] - o)) / 6.0;
  return sum;
}

/// Largest distance of corners and middles of `from` from the other triangles; of some, where there are many.
double distance(const Triangles& from, const Triangles& to) {
  double most = 0.0;
  const std::size_t step = 1 + from.size() / 20;
  for (std::size_t i = 0; i < from.size(); i += step)
    for (int k = 0; k < 4; ++k) {
      const dvec3 p = k < 3 ? from[i][std::size_t(k)] : (from[i][0] + from[i][1] + from[i][2]) / 3.0;
      double least = INFINITY;
      for (const auto& t : to) {
        const double reach = std::max(glm::length(t[1] - t[0]), glm::length(t[2] - t[0]));
        if (glm::length(p - t[0]) - reach < least) least = std::min(least, tests::distance_to_triangle(p, t));
      }
      most = std::max(most, least);
    }
  return most;
}

Affine random_placement(std::mt19937& random, double reach, bool mirrored, double scale) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> far(-reach, reach);
  const dvec3 x = glm::normalize(dvec3(normal(random), normal(random), normal(random)));
  const dvec3 y = glm::normalize(glm::cross(x, dvec3(normal(random), normal(random), normal(random))));
  return {scale * dmat3(x, y, glm::cross(x, y) * (mirrored ? -1.0 : 1.0)), {far(random), far(random), far(random)}};
}

class TilesWriter : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("sightline_tiles_writer_") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path tiles() const { return folder_ / "tiles of it"; }
  std::size_t files_beside() const {
    return std::size_t(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  TilesWriteReport write(TilesWriteOptions options = {.compress = false}) {
    const auto written = write_tiles(scene_, scene_.root(), tiles(), options);
    EXPECT_TRUE(written) << written.error().message;
    EXPECT_EQ(files_beside(), 1u);
    return written ? *written : TilesWriteReport();
  }

  void add_plant(std::uint64_t items, std::uint64_t seed = 7) {
    ASSERT_TRUE(generate_plant({.items = items, .seed = seed}, scene_));
    ASSERT_TRUE(scene_.commit());
  }

  /// Items of many kinds and sizes, each on a node of its own, about `centre`.
  void add_zoo(unsigned seed, const dvec3& centre) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> length(0.2f, 3.0f), angle(-0.5f, 0.5f);
    const core::MeshId torus = scene_.add_mesh(tests::bumpy_torus(20, 0.1)).value(),
                       hills = scene_.add_mesh(tests::terrain(28, 0.8)).value(),
                       small = scene_.add_mesh(tests::bumpy_torus(3, 0.0)).value();
    for (int i = 0; i < 120; ++i) {
      const double scale = std::exp2(std::uniform_real_distribution<double>(-6.0, 2.0)(random));
      Affine placement = random_placement(random, 40.0, i % 5 == 1, scale);
      if (i % 7 == 3) placement.linear[0] += 0.4 * placement.linear[1];
      placement.origin += centre;
      const core::NodeId node = scene_.add_node(scene_.root(), "n" + std::to_string(i));
      const auto some = [&] { return length(random) * (random() % 8 ? 1.0f : -1.0f); };
      const core::Primitive solids[] = {core::Box{some(), some(), some()},
                                        core::Cylinder{some(), some()},
                                        core::Sphere{some()},
                                        core::EllipticalDish{some(), some()},
                                        core::SphericalDish{some(), some()},
                                        core::CircularTorus{4.0f, length(random), length(random)},
                                        core::RectangularTorus{1, 2, 1, 2},
                                        core::Pyramid{2, 3, 1, 3, 0, 0, 1},
                                        core::Snout{some(), some(), some(), angle(random), angle(random), 0, 0, 0, 0},
                                        core::Cylinder{0.01f, 30.0f}};
      if (i % 3 == 0)
        scene_.add_mesh_instance(node, i % 9 == 0 ? torus : i % 9 == 3 ? hills : small, placement);
      else
        scene_.add_primitive(node, solids[std::size_t(i / 3) % std::size(solids)], placement);
    }
    ASSERT_TRUE(scene_.commit());
  }

  /// Triangles of an item in the world, cut by another way than the writer's.
  Triangles twin(core::ItemId item, double tolerance) const {
    const Affine world = scene_.state(item).world_from_item;
    const bool primitive = int(scene_.kind(item)) < core::kPrimitiveKindCount;
    const core::Mesh cut =
        primitive
            ? gpuprims::tessellate(scene_.primitive(item),
                                   {.chord_tolerance = tolerance / largest_scale(world.linear), .max_segments = 1024})
            : scene_.mesh(scene_.mesh_of(item));
    Triangles all;
    for (std::size_t i = 0; i < cut.indices.size(); i += 3) {
      auto& t = all.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) t[k] = core::transform_point(world, dvec3(cut.positions[cut.indices[i + k]]));
    }
    return all;
  }
  double size_of(core::ItemId item) const {
    return glm::length(scene_.bounds_under(item, scene_.state(item).world_from_item).size());
  }
  /// Items by the number of their node.
  std::map<std::uint32_t, std::vector<core::ItemId>> items_by_node() const {
    std::map<std::uint32_t, std::vector<core::ItemId>> items;
    for (core::ItemId i{0}; to_index(i) < scene_.item_slots(); ++i)
      if (scene_.contains_item(i)) items[scene_.node_of(i).index].push_back(i);
    return items;
  }
  static Triangles in_world(const TilesStructure::Tile& tile, const Triangles& triangles) {
    Triangles moved = triangles;
    for (auto& t : moved)
      for (dvec3& p : t) p = core::transform_point(tile.world_from_tile, p);
    return moved;
  }

  /// What the leaves show, by node, in the world.
  static std::map<std::uint32_t, Triangles> in_leaves(const TilesStructure& structure) {
    std::map<std::uint32_t, Triangles> all;
    for (const auto& tile : structure.tiles) {
      if (!tile.children.empty()) continue;
      const TileTriangles content(tile.content);
      for (const auto& feature : content.features) {
        if (feature.triangles.empty()) continue;
        const Triangles there = in_world(tile, feature.triangles);
        auto& to = all[std::uint32_t(feature.node)];
        to.insert(to.end(), there.begin(), there.end());
      }
    }
    return all;
  }

  fs::path folder_;
  core::Scene scene_;
};

TEST_F(TilesWriter, TheTilesetIsValid) {
  add_plant(3000);
  const TilesWriteReport report = write({.compress = false, .tile_triangles = 3000});
  const TilesStructure structure(tiles());
  EXPECT_EQ(structure.problems, "");
  EXPECT_EQ(structure.tiles.size(), report.tiles);
  EXPECT_GE(report.levels, 3u);
  std::size_t leaves = 0, deepest = 0, triangles = 0;
  std::uint64_t bytes = fs::file_size(tiles() / "tileset.json");
  for (const auto& tile : structure.tiles) {
    leaves += tile.children.empty();
    deepest = std::max(deepest, tile.depth + 1);
    if (tile.children.empty()) {
      EXPECT_EQ(tile.error, 0.0);
    }
    if (tile.content.empty()) continue;
    bytes += fs::file_size(tile.content);
    const TileTriangles content(tile.content);
    EXPECT_EQ(content.structure.problems, "") << tile.content;
    // Or of a single item.
    const auto shown = std::ranges::count_if(content.features, [](const auto& of) { return !of.triangles.empty(); });
    EXPECT_TRUE(content.triangles <= 3000u || shown == 1) << content.triangles << " triangles of " << shown;
    triangles += content.triangles;
  }
  EXPECT_EQ(report.leaves, leaves);
  EXPECT_EQ(report.levels, deepest);
  EXPECT_EQ(report.triangles, triangles);
  EXPECT_EQ(report.bytes, bytes);
  EXPECT_EQ(report.left_out, 0u);
  EXPECT_EQ(report.root_error, structure.tiles[0].error);
  EXPECT_GT(report.root_error, 0.001);
  EXPECT_EQ(report.whole_error, structure.json["geometricError"].get<double>());
  EXPECT_EQ(structure.json["asset"]["extras"]["tolerance"], 0.001);
}

/// By their area: an item too much or too few shows in its node's.
TEST_F(TilesWriter, LeavesShowEachItemOnce) {
  add_plant(1000);
  write({.tolerance = 0.0001, .compress = false, .tile_triangles = 50'000});
  const auto shown = in_leaves(TilesStructure(tiles()));
  const auto items = items_by_node();
  EXPECT_EQ(shown.size(), items.size());
  for (const auto& [node, of_node] : items) {
    double wanted = 0.0, least = INFINITY;
    for (const core::ItemId item : of_node) {
      const double of_item = area(twin(item, 0.0001));
      wanted += of_item;
      if (of_item > 0.0) least = std::min(least, of_item);
    }
    ASSERT_TRUE(shown.contains(node)) << node;
    EXPECT_NEAR(area(shown.at(node)), wanted, std::min(0.02 * wanted, 0.5 * least)) << node;
  }
}

TEST_F(TilesWriter, TilesOfAnyCutAreWithinTheirErrors) {
  if (!lod::builds_levels()) GTEST_SKIP() << "this build has no levels of detail";
  for (unsigned seed = 0; seed < 2; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    scene_ = core::Scene();
    add_zoo(seed, seed == 1 ? dvec3(1e7, -3e6, 40) : dvec3(0.0));
    const TilesWriteReport report = write({.tolerance = 0.005, .compress = false, .tile_triangles = 2500});
    EXPECT_EQ(report.left_out, 0u);
    const TilesStructure structure(tiles());
    ASSERT_EQ(structure.problems, "");
    std::map<std::uint32_t, Triangles> exact;
    const auto items = items_by_node();
    const auto twin_error = [&](core::ItemId item) { return std::max(0.0005, 0.001 * size_of(item)); };
    for (const auto& [node, of_node] : items) exact[node] = twin(of_node[0], twin_error(of_node[0]));
    std::size_t coarse = 0, absent = 0;
    // The items that lie below each tile: those of its leaves.
    std::vector<std::set<std::uint32_t>> below(structure.tiles.size());
    for (std::size_t i = structure.tiles.size(); i-- > 0;) {
      const auto& tile = structure.tiles[i];
      const TileTriangles content =
          tile.content.empty() ? TileTriangles(structure.tiles.back().content) : TileTriangles(tile.content);
      for (const std::size_t child : tile.children) below[i].insert(below[child].begin(), below[child].end());
      std::map<std::uint32_t, Triangles> shown;
      if (!tile.content.empty())
        for (const auto& feature : content.features)
          if (!feature.triangles.empty()) shown[std::uint32_t(feature.node)] = in_world(tile, feature.triangles);
      if (tile.children.empty())
        for (const auto& [node, triangles] : shown) below[i].insert(node);
      const double error = tile.children.empty() ? 0.005 : tile.error;
      for (const std::uint32_t node : below[i]) {
        if (!shown.contains(node)) {
          EXPECT_LE(size_of(items.at(node)[0]), error) << "an item is lost";
          ++absent;
          continue;
        }
        const double most = error + twin_error(items.at(node)[0]);
        // Parts of meshes that are divided lie in several leaves.
        EXPECT_LE(distance(shown[node], exact[node]), most) << scene_.name(scene_.node_of(items.at(node)[0]));
        const bool divided = scene_.kind(items.at(node)[0]) == core::Kind::kMesh && tile.children.empty();
        if (!divided) {
          EXPECT_LE(distance(exact[node], shown[node]), most);
        }
        coarse += shown[node].size() < exact[node].size();
      }
    }
    EXPECT_EQ(below[0].size(), items.size());
    EXPECT_GT(coarse, 20u);
    EXPECT_GT(absent, 20u);
  }
}

TEST_F(TilesWriter, BoxesHoldWhatTilesShow) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    scene_ = core::Scene();
    add_zoo(seed, seed % 2 ? dvec3(-2e7 / 3, 1e6 + 0.1, 12) : dvec3(0.0));
    write({.tolerance = 0.01, .compress = false, .tile_triangles = seed < 2 ? 2000u : 65'536u});
    const TilesStructure structure(tiles());
    ASSERT_EQ(structure.problems, "");
    for (const auto& tile : structure.tiles) {
      if (tile.content.empty()) continue;
      const TileTriangles content(tile.content);
      for (int i = 0; i < 3; ++i) {
        EXPECT_LE(tile.box.min[i], content.box.min[i]);
        EXPECT_GE(tile.box.max[i], content.box.max[i]);
      }
      // Relative to a centre of its own.
      EXPECT_LE(glm::length(tile.box.centre()), 1e-3 * glm::length(tile.box.size()));
    }
  }
}

/// A detail of a tenth of a millimetre survives ten thousand kilometres from the origin.
TEST_F(TilesWriter, FarModelsKeepTheirDetail) {
  const dvec3 far(1e7 + 1.0 / 3, -2e7 / 3, 5);
  const core::NodeId node = scene_.add_node(scene_.root(), "part", core::translation(far));
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0.0001f, 0, 0}, {0, 0.0001f, 0}};
  mesh.indices = {0, 1, 2};
  scene_.add_mesh_instance(node, scene_.add_mesh(mesh).value());
  ASSERT_TRUE(scene_.commit());
  write();
  const TilesStructure structure(tiles());
  EXPECT_EQ(structure.problems, "");
  const TileTriangles content(structure.tiles[0].content);
  const auto& t = content.features.at(0).triangles.at(0);
  EXPECT_NEAR(t[1].x - t[0].x, 0.0001, 1e-8);
  EXPECT_NEAR(t[2].y - t[0].y, 0.0001, 1e-8);
  EXPECT_NEAR(glm::length(structure.tiles[0].world_from_tile.origin + t[0] - far), 0.0, 3e-9);
}

TEST_F(TilesWriter, CompressedContentIsTheSame) {
  add_plant(2000);
  const TilesWriteReport plain = write({.compress = false, .tile_triangles = 10'000});
  fs::rename(tiles(), folder_ / "plain");
  const auto written = write_tiles(scene_, scene_.root(), tiles(), {.tile_triangles = 10'000});
  ASSERT_TRUE(written);
  EXPECT_EQ(written->tiles, plain.tiles);
  EXPECT_EQ(written->triangles, plain.triangles);
  EXPECT_EQ(text_of(tiles() / "tileset.json"), text_of(folder_ / "plain" / "tileset.json"));
#ifdef SIGHTLINE_HAVE_MESHOPT
  EXPECT_LT(written->bytes, plain.bytes * 2 / 3);
  for (const auto& tile : TilesStructure(tiles()).tiles) {
    if (tile.content.empty()) continue;
    // Both through the reader, whose decoder is the library's.
    const auto read = [&](const fs::path& file) {
      core::Scene scene;
      EXPECT_TRUE(import_file(file, scene, scene.root(), {.copies = MeshCopies::kExact}));
      EXPECT_TRUE(scene.commit());
      std::multiset<std::array<double, 7>> items;
      std::vector<core::vec3> normals;
      for (core::ItemId i{0}; to_index(i) < scene.item_slots(); ++i) {
        const Affine world = scene.state(i).world_from_item;
        const core::AabbD box = scene.bounds_under(i, world);
        const core::Mesh& mesh = scene.mesh(scene.mesh_of(i));
        items.insert({box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z, double(mesh.indices.size())});
        normals.insert(normals.end(), mesh.normals.begin(), mesh.normals.end());
      }
      return std::pair(items, normals);
    };
    const auto [items, normals] = read(tile.content);
    const auto [plain_items, plain_normals] = read(folder_ / "plain" / "tiles" / tile.content.filename());
    EXPECT_EQ(items, plain_items) << tile.content;
    ASSERT_EQ(normals.size(), plain_normals.size());
    double most = 0.0;
    for (std::size_t k = 0; k < normals.size(); ++k) {
      const dvec3 a(normals[k]), b(plain_normals[k]);
      most = std::max(most, std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
    }
    EXPECT_LE(most, kMeshoptNormalError);
    EXPECT_GT(most, 0.001);
  }
#else
  EXPECT_EQ(written->bytes, plain.bytes);
#endif
}

TEST_F(TilesWriter, SharedMeshesAreInstances) {
  std::mt19937 random(5);
  const core::NodeId group = scene_.add_node(scene_.root(), "bolts");
  const core::MeshId mesh = scene_.add_mesh(tests::bumpy_torus(12, 0.1)).value();
  for (int i = 0; i < 40; ++i) {
    Affine placement = random_placement(random, 20.0, i % 4 == 0, 0.1);
    if (i == 7) placement.linear[0] += 0.5 * placement.linear[1];  // sheared
    scene_.add_mesh_instance(scene_.add_node(group, "bolt " + std::to_string(i)), mesh, placement);
  }
  ASSERT_TRUE(scene_.commit());
  const TilesWriteReport report = write();
  EXPECT_EQ(report.instances, 39u);
  const TilesStructure structure(tiles());
  const TileTriangles content(structure.tiles[0].content);
  EXPECT_EQ(content.instances, 39u);
  EXPECT_EQ(content.structure.json["meshes"].size(), 3u) << "one, its mirror image, and one alone";
  const auto shown = in_leaves(structure);
  for (core::ItemId i{0}; to_index(i) < 40; ++i) {
    const Triangles there = shown.at(scene_.node_of(i).index), wanted = twin(i, 0.001);
    ASSERT_EQ(there.size(), wanted.size());
    EXPECT_LE(distance(there, wanted), 1e-5);
    // Mirror images face outwards as well.
    EXPECT_NEAR(volume(there), std::abs(volume(wanted)), 1e-3 * std::abs(volume(wanted)));
    EXPECT_GT(std::abs(volume(wanted)), 1e-3);
  }
}

TEST_F(TilesWriter, LargeMeshesAreDivided) {
  const core::NodeId node = scene_.add_node(scene_.root(), "hills");
  scene_.add_mesh_instance(node, scene_.add_mesh(tests::terrain(90, 0.8)).value());
  ASSERT_TRUE(scene_.commit());
  const TilesWriteReport report = write({.compress = false, .tile_triangles = 3000});
  EXPECT_EQ(report.divided, 1u);
  EXPECT_EQ(report.items[std::size_t(core::Kind::kMesh)], 1u);
  EXPECT_EQ(report.leaf_triangles, 2u * 90 * 90);
  const TilesStructure structure(tiles());
  EXPECT_EQ(structure.problems, "");
  EXPECT_GT(structure.tiles.size(), 6u);
  const Triangles all = in_leaves(structure).at(node.index);
  EXPECT_EQ(all.size(), 2u * 90 * 90);
  EXPECT_NEAR(area(all), area(twin(core::ItemId{0}, 1.0)), 1e-3);
  if (lod::builds_levels()) {
    EXPECT_FALSE(structure.tiles[0].content.empty());
    EXPECT_LT(report.root_error, 2.0);
  }
}

TEST_F(TilesWriter, FeaturesHaveNamesAttributesAndParents) {
  const core::NodeId zone = scene_.add_node(scene_.root(), "zone"), pipe = scene_.add_node(zone, "pipe \"1\" é"),
                     valve = scene_.add_node(pipe, ""), old = scene_.add_node(zone, "caf\xe9");
  scene_.set_attribute(zone, "Area", "12");
  scene_.set_attribute(valve, "Nominal bore", "50 mm");
  scene_.set_attribute(valve, "name", "V-1");
  scene_.set_attribute(pipe, "Nominal-bore", "80 mm");
  scene_.set_attribute(old, "1st", "");
  scene_.add_primitive(valve, core::Box{1, 1, 1});
  scene_.add_primitive(valve, core::Sphere{2});
  scene_.add_primitive(pipe, core::Cylinder{0.1f, 9}, core::translation({5, 0, 0}));
  scene_.add_primitive(old, core::Line{0, 3});
  ASSERT_TRUE(scene_.commit());
  write();
  const TileTriangles content(TilesStructure(tiles()).tiles[0].content);
  EXPECT_EQ(content.structure.problems, "");
  ASSERT_EQ(content.rows, 4u);
  const auto nodes = content.numbers("node"), parents = content.numbers("parent");
  const auto row = [&](core::NodeId node) {
    return std::size_t(std::find(nodes.begin(), nodes.end(), node.index) - nodes.begin());
  };
  EXPECT_EQ(content.strings("name")[row(zone)], "zone");
  EXPECT_EQ(content.strings("name")[row(pipe)], "pipe \"1\" é");
  EXPECT_EQ(content.strings("name")[row(valve)], "");
  EXPECT_EQ(content.strings("name")[row(old)], "café");
  EXPECT_EQ(parents[row(valve)], row(pipe));
  EXPECT_EQ(parents[row(pipe)], row(zone));
  EXPECT_EQ(parents[row(zone)], row(zone)) << "nothing is above";
  EXPECT_EQ(content.strings("Nominal_bore")[row(valve)], "50 mm");
  EXPECT_EQ(content.strings("Nominal_bore_2")[row(pipe)], "80 mm");
  EXPECT_EQ(content.strings("name_2")[row(valve)], "V-1");
  EXPECT_EQ(content.strings("Area")[row(zone)], "12");
  const Json& properties =
      content.structure.json["extensions"]["EXT_structural_metadata"]["schema"]["classes"]["part"]["properties"];
  EXPECT_EQ(properties["Nominal_bore_2"]["name"], "Nominal-bore");
  EXPECT_FALSE(properties.contains("_1st")) << "all of it is empty";
  EXPECT_EQ(content.features[row(valve)].triangles.size(),
            content.triangles - content.features[row(pipe)].triangles.size());
}

TEST_F(TilesWriter, MaterialsComeAlong) {
  const core::MaterialId red = scene_.add_material({.name = "red \"paint\"", .colour = {1, 0, 0}}),
                         glass = scene_.add_material({.name = "", .colour = {0.5f, 0.5f, 1}, .alpha = 0.25f});
  int at = 0;
  for (const core::MaterialId material : {red, glass, core::MaterialId{}, red})
    scene_.add_primitive(scene_.add_node(scene_.root()), core::Box{1, 1, 1}, core::translation({2.0 * at++, 0, 0}),
                         material);
  ASSERT_TRUE(scene_.commit());
  write();
  const Json json = TileTriangles(TilesStructure(tiles()).tiles[0].content).structure.json;
  ASSERT_EQ(json["materials"].size(), 3u);
  std::map<std::size_t, std::size_t> vertices;  // by material
  for (const Json& primitive : json["meshes"][0]["primitives"])
    vertices[primitive["material"].get<std::size_t>()] =
        json["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()]["count"].get<std::size_t>();
  EXPECT_EQ(vertices, (std::map<std::size_t, std::size_t>{{0, 48}, {1, 24}, {2, 24}}));
  EXPECT_EQ(json["materials"][0]["name"], "red \"paint\"");
  EXPECT_EQ(json["materials"][1]["alphaMode"], "BLEND");
  EXPECT_NEAR(json["materials"][2]["pbrMetallicRoughness"]["baseColorFactor"][0].get<double>(), 0.448, 0.001)
      << "items without a material have the default one";
}

TEST_F(TilesWriter, WhatIsHiddenIsLeftOut) {
  const core::NodeId shown = scene_.add_node(scene_.root(), "shown"), hidden = scene_.add_node(scene_.root(), "hidden");
  const core::NodeId volume = scene_.add_node(shown, "volume");
  scene_.set_layers(volume, core::kLayerObstruction);
  scene_.set_visible(hidden, false);
  for (const core::NodeId node : {shown, hidden, volume}) scene_.add_primitive(node, core::Box{1, 2, 3});
  scene_.add_primitive(shown, core::Cylinder{0, 1});
  scene_.add_primitive(shown, core::Line{0, 1});
  scene_.add_mesh_instance(shown, scene_.add_mesh({}).value());
  const TilesWriteReport report = write();
  EXPECT_EQ(report.left_out, 4u);
  EXPECT_EQ(report.items[std::size_t(core::Kind::kBox)], 1u);
  EXPECT_EQ(report.items[std::size_t(core::Kind::kLine)], 1u);
  const TileTriangles content(TilesStructure(tiles()).tiles[0].content);
  EXPECT_EQ(content.triangles, 12u);
  EXPECT_EQ(content.rows, 1u);
  const TilesWriteReport rows = write({.collections = true});
  EXPECT_EQ(rows.left_out, 5u) << "the convention has no lines";
}

/// Each leaf is a file of the convention with z up; tiles place it.
TEST_F(TilesWriter, CollectionsKeepPrimitives) {
  add_plant(2000);
  const TilesWriteReport report = write({.collections = true, .tile_triangles = 10'000});
  EXPECT_GE(report.analytic, 1900u);
  EXPECT_EQ(report.left_out, 0u);
  const TilesStructure structure(tiles());
  EXPECT_EQ(structure.problems, "");
  EXPECT_GT(structure.tiles.size(), 5u);
  std::map<std::string, std::vector<core::AabbD>> boxes;
  for (const auto& tile : structure.tiles) {
    if (tile.content.empty()) continue;
    core::Scene scene;
    ASSERT_TRUE(import_file(tile.content, scene, scene.root(), {.copies = MeshCopies::kExact}));
    ASSERT_TRUE(scene.commit());
    // The viewer turns content from y up; the root's transform takes that back.
    const Affine z_from_y{dmat3(1, 0, 0, 0, 0, 1, 0, -1, 0), dvec3(0.0)}, world = tile.world_from_tile * z_from_y;
    EXPECT_EQ(world.linear, dmat3(1.0));
    for (core::ItemId i{0}; to_index(i) < scene.item_slots(); ++i) {
      core::AabbD box = scene.bounds_under(i, scene.state(i).world_from_item);
      const core::AabbD rows{box.min - 1e-4, box.max + 1e-4}, outer = tile.box;  // in the frame with y up
      EXPECT_LE(outer.min.x, rows.max.x);
      EXPECT_LE(-outer.max.y, rows.max.z);
      EXPECT_LE(outer.min.x, rows.min.x + 1e-3);
      EXPECT_GE(outer.max.x, rows.max.x - 1e-3);
      if (!tile.children.empty()) {
        EXPECT_GT(glm::length(box.size()), 0.9 * tile.error);
        continue;
      }
      box.min += world.origin, box.max += world.origin;
      boxes[std::string(scene.name(scene.node_of(i)))].push_back(box);
    }
  }
  std::size_t found = 0;
  for (core::ItemId i{0}; to_index(i) < scene_.item_slots(); ++i) {
    const core::AabbD wanted = scene_.bounds_under(i, scene_.state(i).world_from_item);
    auto& there = boxes[std::string(scene_.name(scene_.node_of(i)))];
    const auto same = std::find_if(there.begin(), there.end(), [&](const core::AabbD& box) {
      return glm::length(box.min - wanted.min) < 0.003 && glm::length(box.max - wanted.max) < 0.003;
    });
    ASSERT_NE(same, there.end()) << scene_.path(scene_.node_of(i));
    there.erase(same);
    ++found;
  }
  EXPECT_EQ(found, 2000u);
  for (const auto& [name, rest] : boxes) EXPECT_TRUE(rest.empty()) << name;
}

TEST_F(TilesWriter, TheSameSceneGivesTheSameBytes) {
  add_zoo(3, dvec3(0.0));
  write({.tile_triangles = 3000});
  fs::rename(tiles(), folder_ / "before");
  ASSERT_TRUE(write_tiles(scene_, scene_.root(), tiles(), {.tile_triangles = 3000}));
  std::size_t files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(tiles())) {
    if (!entry.is_regular_file()) continue;
    ++files;
    EXPECT_EQ(text_of(entry.path()), text_of(folder_ / "before" / fs::relative(entry.path(), tiles())));
  }
  EXPECT_GT(files, 5u);
}

TEST_F(TilesWriter, FoldersAppearWholeOrNotAtAll) {
  scene_.add_primitive(scene_.root(), core::Box{1, 2, 3});
  const auto fails = [&](const fs::path& folder, const TilesWriteOptions& options, const std::string& part) {
    const std::size_t before = files_beside();
    const auto written = write_tiles(scene_, scene_.root(), folder, options);
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message.find(part), std::string::npos) << written.error().message;
    EXPECT_EQ(files_beside(), before);
  };
  fails(tiles(), {.progress = [](double) { return false; }}, std::string(kCancelled));
  int calls = 0;
  fails(tiles(), {.progress = [&](double share) { return ++calls < 100 && share < 0.5; }}, std::string(kCancelled));
  fails(folder_ / "none" / "a", {}, "cannot be written");
  for (const double tolerance : {0.0, -1.0, double(NAN), double(INFINITY)})
    fails(tiles(), {.tolerance = tolerance}, "tolerance");
  fails(tiles(), {.tile_triangles = 0}, "triangle");
  std::ofstream(folder_ / "file") << "text";
  fails(folder_ / "file", {}, "found a file");
  fs::create_directories(folder_ / "photos");
  std::ofstream(folder_ / "photos" / "tileset.json") << "{\"asset\":{\"version\":\"1.1\"}}";
  fails(folder_ / "photos", {}, "would be lost");
  fs::create_directories(tiles());  // empty
  ASSERT_TRUE(write_tiles(scene_, scene_.root(), tiles() / "", {}));
  const std::string before = text_of(tiles() / "tileset.json");
  std::ofstream(tiles() / "index.html") << "a page of the user's";
  fails(tiles(), {}, "would be lost");
  fs::remove(tiles() / "index.html");
  scene_.add_primitive(scene_.root(), core::Box{1, 2, 30});
  fails(tiles(), {.progress = [](double share) { return share < 0.5; }}, std::string(kCancelled));
  EXPECT_EQ(text_of(tiles() / "tileset.json"), before);
  ASSERT_TRUE(write_tiles(scene_, scene_.root(), tiles(), {}));
  EXPECT_NE(text_of(tiles() / "tileset.json"), before);
  EXPECT_EQ(files_beside(), 3u);
  scene_ = core::Scene();
  fails(tiles(), {}, "nothing to show");
}

TEST_F(TilesWriter, ProgressRises) {
  add_plant(1000);
  double last = 0.0;
  write({.tile_triangles = 2000, .progress = [&](double share) {
           EXPECT_GE(share, last);
           EXPECT_LE(share, 1.0);
           last = share;
           return true;
         }});
  EXPECT_GT(last, 0.9);
}

}  // namespace
}  // namespace sightline::importers::tiles_writer_test
