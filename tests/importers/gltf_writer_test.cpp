// Scenes written as glTF: their structure checked without the reader, and read back.
#include "sightline/importers/gltf/gltf_writer.h"

#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sightline/importers/import.h"
#include "sightline/importers/internal/file_bytes.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/tests/importers/gltf_structure.h"

namespace sightline::importers::gltf_writer_test {
namespace {

namespace fs = std::filesystem;
using core::Affine;
using core::dmat3;
using core::dvec3;
using Json = json::Value;

class GltfWriter : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("sightline_gltf_writer_") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::size_t files() const {
    return std::size_t(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  /// Writes the scene below its root, checks the file and reads it into `again_`, below top_.
  GltfWriteReport round_trip(const GltfWriteOptions& options = {}, const std::string& name = "a b.glb") {
    const auto written = write_gltf(scene_, scene_.root(), folder_ / name, options);
    EXPECT_TRUE(written) << written.error().message;
    if (!written) return {};
    const auto bytes = read_file_bytes(folder_ / name).value();
    if (name.ends_with(".glb")) {
      tests::GltfStructure structure(bytes);
      EXPECT_EQ(structure.problems, "");
      json_ = structure.json;
      EXPECT_EQ(written->bytes, bytes.size());
    }
    again_ = core::Scene();
    const auto read = import_file(folder_ / name, again_, again_.root(), {.copies = MeshCopies::kExact});
    EXPECT_TRUE(read) << read.error().message;
    if (read) {
      top_ = read->nodes[0];
      EXPECT_EQ(read->warnings.size(), scene_.item_count() == 0 ? 1u : 0u);
      EXPECT_TRUE(again_.commit());
    }
    return *written;
  }

  /// The path below the written node, without the name that an item's own node got.
  std::string path(const core::Scene& scene, core::ItemId item, core::NodeId below) const {
    const std::string all = scene.path(scene.node_of(item)), top = scene.path(below);
    return all.substr(top.empty() ? 0 : top.size() + 1);
  }
  static std::vector<dvec3> corners(const core::Scene& scene, core::ItemId item) {
    const Affine world = scene.state(item).world_from_item;
    const core::Mesh& mesh = scene.mesh(scene.mesh_of(item));
    std::vector<dvec3> out;
    for (const std::uint32_t i : mesh.indices) out.push_back(core::transform_point(world, dvec3(mesh.positions[i])));
    return out;
  }
  static core::AabbD box(const core::Scene& scene, core::ItemId item) {
    return scene.bounds_under(item, scene.state(item).world_from_item);
  }
  static void expect_near(const core::AabbD& a, const core::AabbD& b, double tolerance) {
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(a.min[i], b.min[i], tolerance);
      EXPECT_NEAR(a.max[i], b.max[i], tolerance);
    }
  }
  static core::Material look(const core::Scene& scene, core::ItemId item) {
    const auto material = scene.state(item).material;
    return material == core::kNone ? core::Material{} : scene.material(scene.material_at(material));
  }
  /// Every item of the scene has one of the same place, look and box in the scene that came back. `kinds`: of the same
  /// kind, too, but for those that became meshes.
  void expect_same_items(double tolerance, const std::map<core::Kind, core::Kind>& kinds) {
    std::multimap<std::string, core::ItemId> there;
    std::size_t count = 0;
    for (core::ItemId i{0}; to_index(i) < again_.item_slots(); ++i)
      if (again_.contains_item(i)) there.emplace(path(again_, i, top_), i), ++count;
    EXPECT_EQ(count, scene_.item_count());
    for (core::ItemId i{0}; to_index(i) < scene_.item_slots(); ++i) {
      const std::string name = path(scene_, i, scene_.root());
      const core::AabbD wanted = box(scene_, i);
      const auto mapped = kinds.find(scene_.kind(i));
      const core::Kind kind = mapped == kinds.end() ? scene_.kind(i) : mapped->second;
      auto best = there.end();
      double least = INFINITY;
      // An item's own node lies below its group's.
      for (auto at = there.lower_bound(name); at != there.end() && at->first.starts_with(name); ++at) {
        const core::AabbD found = box(again_, at->second);
        double off = 0.0;
        for (int k = 0; k < 3; ++k)
          off = std::max({off, std::abs(found.min[k] - wanted.min[k]), std::abs(found.max[k] - wanted.max[k])});
        if (kinds.contains(core::Kind::kMesh) || again_.kind(at->second) == kind)
          if (off < least) least = off, best = at;
      }
      ASSERT_NE(best, there.end()) << name << " " << core::name_of(scene_.kind(i));
      EXPECT_LE(least, mapped == kinds.end() ? tolerance : tolerance + 0.001)
          << name << " " << core::name_of(scene_.kind(i));
      const core::Material a = look(scene_, i), b = look(again_, best->second);
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(a.colour[k], b.colour[k], 0.51 / 255) << name;
      there.erase(best);
    }
  }

  fs::path folder_;
  core::Scene scene_, again_;
  core::NodeId top_;
  Json json_;
};

core::Mesh random_mesh(std::mt19937& random, bool normals) {
  std::uniform_real_distribution<float> coordinate(-1.0f, 1.0f);
  core::Mesh mesh;
  mesh.name = "part \"x\"";
  for (int i = 0; i < 20; ++i) {
    mesh.positions.emplace_back(coordinate(random), coordinate(random), coordinate(random));
    if (normals) mesh.normals.push_back(3.0f * glm::normalize(mesh.positions.back()));
  }
  for (std::uint32_t i = 0; i < 60; ++i) mesh.indices.push_back(i < 20 ? i : std::uint32_t(random() % 20));
  return mesh;
}

Affine random_placement(std::mt19937& random, double reach, bool mirrored, double scale) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> far(-reach, reach);
  const dvec3 x = glm::normalize(dvec3(normal(random), normal(random), normal(random)));
  const dvec3 y = glm::normalize(glm::cross(x, dvec3(normal(random), normal(random), normal(random))));
  return {scale * dmat3(x, y, glm::cross(x, y) * (mirrored ? -1.0 : 1.0)), {far(random), far(random), far(random)}};
}

TEST_F(GltfWriter, MeshesComeBack) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    scene_ = core::Scene();
    const core::NodeId group =
        scene_.add_node(scene_.root(), "zone /\xff 1", random_placement(random, 1e6, false, 2.0));
    scene_.set_attribute(group, "Type", "'ZONE'\n");
    const core::MeshId mesh = scene_.add_mesh(random_mesh(random, seed % 2 == 0)).value();
    for (int i = 0; i < 6; ++i) {
      Affine placement = random_placement(random, 10.0, i % 2 == 1, 0.5);
      if (i == 4) placement.linear[0] += 0.3 * placement.linear[1];  // sheared: baked
      if (i == 5) placement = {};
      const core::NodeId node = i < 3 ? group : scene_.add_node(group, "item " + std::to_string(i));
      scene_.add_mesh_instance(node, mesh, placement,
                               scene_.add_material({.name = i == 2 ? "" : "paint",
                                                    .colour = {0.1f * float(i), 0.5f, 1.0f},
                                                    .alpha = i == 3 ? 0.25f : 1.0f}));
    }
    const GltfWriteReport report = round_trip();
    EXPECT_EQ(report.items[std::size_t(core::Kind::kMesh)], 6u);
    EXPECT_EQ(report.left_out, 0u);
    EXPECT_EQ(report.meshes, 2u);  // one of them is the sheared one
    EXPECT_EQ(report.triangles, 40u);
    ASSERT_EQ(again_.item_count(), 6u);
    std::map<int, int> positions;
    for (const Json& m : json_["meshes"]) ++positions[m["primitives"][0]["attributes"]["POSITION"].get<int>()];
    EXPECT_EQ(positions.size(), 2u);
    for (core::ItemId i{0}; to_index(i) < 6; ++i) {
      const std::vector<dvec3> before = corners(scene_, i);
      std::vector<dvec3> after = corners(again_, i);
      ASSERT_EQ(before.size(), after.size());
      if (to_index(i) == 4 && glm::determinant(scene_.placement(core::ItemId{4}).linear) < 0.0)
        for (std::size_t k = 0; k < after.size(); k += 3) std::swap(after[k + 1], after[k + 2]);
      for (std::size_t k = 0; k < before.size(); ++k) ASSERT_LE(glm::length(before[k] - after[k]), 2e-6) << to_index(i);
      EXPECT_EQ(again_.mesh(again_.mesh_of(i)).normals.empty(), seed % 2 == 1);
      EXPECT_NEAR(look(again_, i).alpha, to_index(i) == 3 ? 0.25f : 1.0f, 1e-6);
      EXPECT_EQ(look(again_, i).name, to_index(i) == 2 ? "" : "paint");
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(look(again_, i).colour[c], look(scene_, i).colour[c], 1e-6);
    }
    const core::NodeId zone = again_.first_child(top_);
    EXPECT_EQ(again_.name(zone), "zone /\xEF\xBF\xBD 1");  // a byte that is not UTF-8
    EXPECT_EQ(again_.attributes(zone), scene_.attributes(group));
    EXPECT_EQ(again_.name(again_.node_of(core::ItemId{5})), "item 5");
  }
}

TEST_F(GltfWriter, ManyOfOneMeshAreInstances) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    scene_ = core::Scene();
    const core::NodeId group = scene_.add_node(scene_.root(), "bolts", core::translation({1e7, -2e7 / 3, 5}));
    const core::MeshId mesh = scene_.add_mesh(random_mesh(random, true)).value();
    const std::size_t count = seed % 2 ? kGltfInstancesFrom - 1 : kGltfInstancesFrom + random() % 50;
    for (std::size_t i = 0; i < count; ++i) {
      Affine placement = random_placement(random, 50.0, random() % 2, 0.1);
      // Half turns are where quaternions are hard.
      if (i % 4 == 0)
        for (int c = 0; c < 3; ++c)
          placement.linear[c] = dvec3(0.0), placement.linear[c][c] = i / 4 % 3 == std::size_t(c) ? 1 : -1;
      scene_.add_mesh_instance(group, mesh, placement);
    }
    scene_.add_mesh_instance(group, scene_.add_mesh(random_mesh(random, false)).value());
    round_trip();
    EXPECT_EQ(json_.contains("extensionsRequired"), count >= kGltfInstancesFrom);
    EXPECT_EQ(json_["nodes"].size(), count >= kGltfInstancesFrom ? 3 : 2 + count);
    ASSERT_EQ(again_.item_count(), count + 1);
    for (core::ItemId i{0}; to_index(i) < count; ++i) {
      const std::vector<dvec3> before = corners(scene_, i), after = corners(again_, i);
      ASSERT_EQ(before.size(), after.size());
      for (std::size_t k = 0; k < before.size(); ++k) ASSERT_LE(glm::length(before[k] - after[k]), 2e-5) << to_index(i);
    }
  }
}

TEST_F(GltfWriter, APlantComesBackAsTriangles) {
  ASSERT_TRUE(generate_plant({.items = 3000, .seed = 7}, scene_));
  ASSERT_TRUE(scene_.commit());
  const GltfWriteReport report = round_trip({.tolerance = 0.002});
  EXPECT_EQ(report.left_out, 0u);
  EXPECT_EQ(report.analytic, 0u);
  EXPECT_LE(report.largest_chord_error, 0.002);
  EXPECT_GT(report.largest_chord_error, 0.0005);
  EXPECT_LT(report.meshes, 3000u);
  expect_same_items(0.0021, {{core::Kind::kMesh, core::Kind::kMesh}});
}

TEST_F(GltfWriter, APlantComesBackAnalytic) {
  ASSERT_TRUE(generate_plant({.items = 3000, .seed = 7}, scene_));
  ASSERT_TRUE(scene_.commit());
  const GltfWriteReport report = round_trip({.collections = true});
  EXPECT_EQ(report.left_out, 0u);
  EXPECT_GE(report.analytic, 2900u);
  using core::Kind;
  expect_same_items(1e-4, {{Kind::kRectangularTorus, Kind::kMesh}, {Kind::kPyramid, Kind::kMesh}});
}

/// Extent of an item along a direction.
double reach(const core::Scene& scene, core::ItemId item, const dvec3& direction) {
  const Affine world = scene.state(item).world_from_item;
  return glm::dot(direction, world.origin) +
         core::support(scene.primitive(item), glm::transpose(world.linear) * direction);
}

/// A point of the top rim of a snout of one radius, at an angle of its own.
dvec3 rim(const core::Snout& s, double angle) {
  const double r = std::abs(double(s.bottom_radius)), x = r * std::cos(angle), y = r * std::sin(angle);
  return {x, y, 0.5 * s.height + std::tan(double(s.top_shear_x)) * x + std::tan(double(s.top_shear_y)) * y};
}

TEST_F(GltfWriter, RandomSolidsComeBackThroughCollections) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> length(0.2f, 3.0f), angle(-0.6f, 0.6f), turn(0.1f, 6.2f);
    const auto some = [&] { return length(random) * (random() % 8 ? 1.0f : -1.0f); };
    scene_ = core::Scene();
    const auto add = [&](const core::Primitive& primitive) {
      const core::NodeId node =
          scene_.add_node(scene_.root(), "n" + std::to_string(scene_.item_count()), core::translation({1, 2, 3}));
      Affine placement = random_placement(random, seed % 2 ? 50.0 : 9e5, random() % 3 == 0, 0.5);
      if (random() % 4 == 0 && !std::holds_alternative<core::Snout>(primitive) &&
          !std::holds_alternative<core::SphericalDish>(primitive))
        placement.linear[2] *= 1.7;
      scene_.add_primitive(node, primitive, placement);
    };
    add(core::Box{some(), some(), some()});
    add(core::Cylinder{some(), some()});
    add(core::Sphere{some()});
    add(core::EllipticalDish{some(), some()});
    add(core::SphericalDish{some(), some()});
    add(core::CircularTorus{4.0f, length(random), turn(random)});
    add(core::CircularTorus{4.0f, length(random), 6.2831853f});
    add(core::Snout{some(), some(), some(), 0, 0, 0, 0, 0, 0});
    add(core::Snout{some(), some(), some(), angle(random), angle(random), 0, 0, 0, 0});
    const float radius = length(random), a = angle(random), b = angle(random);
    add(core::Snout{radius, radius, 12.0f, 0, 0, a, b, angle(random), angle(random)});
    add(core::Pyramid{2, 3, 2, 3, 0, 0, 1});
    ASSERT_TRUE(scene_.commit());
    const std::size_t analytic = scene_.item_count();
    const core::ItemId slanted{9};
    // Without a row of their own.
    add(core::Pyramid{2, 3, 1, 3, 0, 0, 1});
    add(core::RectangularTorus{1, 2, 1, 2});
    add(core::Snout{2, 1, 12.0f, 0, 0, a, b, 0, 0});
    add(core::Cylinder{1, 0});
    const GltfWriteReport report = round_trip({.collections = true});
    EXPECT_EQ(report.analytic, analytic);
    ASSERT_EQ(again_.item_count(), scene_.item_count());
    std::map<std::string, core::ItemId> there;
    for (core::ItemId i{0}; to_index(i) < again_.item_slots(); ++i)
      there[std::string(again_.name(again_.node_of(i)))] = i;
    std::normal_distribution<double> normal;
    for (core::ItemId i{0}; to_index(i) < scene_.item_slots(); ++i) {
      const core::ItemId j = there.at("n" + std::to_string(to_index(i)));
      const core::AabbD wanted = box(scene_, i);
      const double size = glm::length(wanted.size());
      // Floats of the file, and of the centre that rows count from.
      const double tolerance = 3e-6 * size + (seed % 2 ? 1e-5 : 0.5);
      SCOPED_TRACE(testing::Message() << core::name_of(scene_.kind(i)));
      // Bounds of a snout with slanted ends are larger than its triangles.
      if (to_index(i) < analytic || scene_.kind(i) != core::Kind::kSnout)
        expect_near(box(again_, j), wanted, to_index(i) < analytic ? tolerance : 0.002 + tolerance);
      EXPECT_EQ(int(again_.kind(j)) < core::kPrimitiveKindCount, to_index(i) < analytic);
      // The support of a slanted end says nothing about the side that it slants to.
      for (int k = 0; k < 8 && i == slanted; ++k) {
        const core::Snout before = std::get<core::Snout>(scene_.primitive(i)),
                          after = std::get<core::Snout>(again_.primitive(j));
        const Affine from = scene_.state(i).world_from_item, to = again_.state(j).world_from_item;
        const dvec3 world = core::transform_point(from, rim(before, k));
        const dvec3 local = glm::inverse(to.linear) * (world - to.origin);
        EXPECT_LE(glm::length(to.linear * (local - rim(after, std::atan2(local.y, local.x)))), tolerance);
      }
      for (int k = 0; k < 20 && to_index(i) < analytic; ++k) {
        const dvec3 d = glm::normalize(dvec3(normal(random), normal(random), normal(random)));
        EXPECT_NEAR(reach(again_, j, d), reach(scene_, i, d), tolerance);
      }
    }
  }
}

TEST_F(GltfWriter, RowsCountFromTheMiddleOfAFarModel) {
  const dvec3 far(1e6 + 0.25, -3e6, 12.5);
  const core::NodeId node = scene_.add_node(scene_.root(), "tank", core::translation(far));
  scene_.set_attribute(node, "Tag", "T-1");
  scene_.add_primitive(node, core::Cylinder{2.0f, 5.0f}, core::translation({0.125, 0, 0}));
  scene_.add_node(scene_.root(), "empty");
  ASSERT_TRUE(scene_.commit());
  round_trip({.collections = true});
  ASSERT_EQ(again_.item_count(), 1u);
  EXPECT_EQ(again_.kind(core::ItemId{0}), core::Kind::kCylinder);
  expect_near(box(again_, core::ItemId{0}), box(scene_, core::ItemId{0}), 1e-6);
  EXPECT_EQ(again_.name(again_.node_of(core::ItemId{0})), "tank");
  EXPECT_EQ(again_.attributes(again_.node_of(core::ItemId{0})), scene_.attributes(node));
  EXPECT_EQ(json_["nodes"].size(), 4u);  // tank, empty, cylinder, its caps
}

TEST_F(GltfWriter, WhatIsHiddenIsLeftOut) {
  const core::NodeId shown = scene_.add_node(scene_.root(), "shown"), hidden = scene_.add_node(scene_.root(), "hidden");
  scene_.add_node(scene_.root(), "empty");
  const core::NodeId volume = scene_.add_node(shown, "");
  scene_.set_layers(volume, core::kLayerObstruction);
  scene_.set_visible(hidden, false);
  const core::NodeId below = scene_.add_node(hidden, "below");
  for (const core::NodeId node : {shown, hidden, volume, below}) scene_.add_primitive(node, core::Box{1, 2, 3});
  const core::MeshId none = scene_.add_mesh({}).value();
  scene_.add_mesh_instance(shown, none);
  for (const bool collections : {false, true}) {
    const GltfWriteReport report = round_trip({.collections = collections});
    EXPECT_EQ(report.left_out, 4u);
    EXPECT_EQ(again_.item_count(), 1u);
    std::string names;
    for (core::NodeId n = again_.first_child(top_); n.valid(); n = again_.next_sibling(n))
      names += std::string(again_.name(n)) + ' ';
    EXPECT_EQ(names.find("shown empty"), 0u) << names;
    EXPECT_EQ(names.find("hidden"), std::string::npos) << names;
  }
}

TEST_F(GltfWriter, TextBesideItsNumbers) {
  scene_.add_primitive(scene_.add_node(scene_.root(), "box"), core::Box{1, 2, 3});
  const GltfWriteReport report = round_trip({}, "a b#1.gltf");
  EXPECT_EQ(files(), 2u);
  EXPECT_EQ(report.bytes, fs::file_size(folder_ / "a b#1.gltf") + fs::file_size(folder_ / "a b#1.bin"));
  const auto text = read_file_bytes(folder_ / "a b#1.gltf").value(),
             numbers = read_file_bytes(folder_ / "a b#1.bin").value();
  const tests::GltfStructure structure(
      json::parse(std::string(reinterpret_cast<const char*>(text.data()), text.size())).value(), numbers);
  EXPECT_EQ(structure.problems, "");
  EXPECT_EQ(again_.item_count(), 1u);
  expect_near(box(again_, core::ItemId{0}), box(scene_, core::ItemId{0}), 1e-6);
}

TEST_F(GltfWriter, LinesAndTheWrittenNodesOwnItems) {
  const core::NodeId part = scene_.add_node(scene_.root(), "part", core::translation({1, 2, 3}));
  scene_.add_primitive(part, core::Box{2, 2, 2});
  scene_.add_primitive(scene_.add_node(part, "wire"), core::Line{0, 5});
  const auto written = write_gltf(scene_, part, folder_ / "part.glb");
  ASSERT_TRUE(written);
  EXPECT_EQ(written->left_out, 0u);
  tests::GltfStructure structure(read_file_bytes(folder_ / "part.glb").value());
  EXPECT_EQ(structure.problems, "");
  EXPECT_EQ(structure.json["meshes"][1]["primitives"][0]["mode"], 1);
  const auto read = import_file(folder_ / "part.glb", again_, again_.root());
  ASSERT_TRUE(read);
  ASSERT_EQ(again_.item_count(), 1u);
  EXPECT_EQ(again_.name(again_.node_of(core::ItemId{0})), "part");
  expect_near(box(again_, core::ItemId{0}), {{0, 1, 2}, {2, 3, 4}}, 1e-6);
}

TEST_F(GltfWriter, AnEmptySceneIsAFile) {
  for (const bool collections : {false, true}) {
    round_trip({.collections = collections});
    EXPECT_EQ(again_.item_count(), 0u);
  }
}

TEST_F(GltfWriter, FailuresLeaveNothing) {
  scene_.add_primitive(scene_.root(), core::Box{1, 2, 3});
  const auto expect_error = [&](const fs::path& path, const GltfWriteOptions& options, const std::string& part) {
    const auto written = write_gltf(scene_, scene_.root(), path, options);
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message.find(part), std::string::npos) << written.error().message;
    EXPECT_EQ(files(), 0u);
  };
  expect_error(folder_ / "none" / "a.glb", {}, "a.glb");
  expect_error(folder_ / "a.obj", {}, ".glb or .gltf");
  for (const double tolerance : {0.0, -1.0, double(NAN), double(INFINITY)})
    expect_error(folder_ / "a.glb", {.tolerance = tolerance}, "tolerance");
  for (const bool collections : {false, true})
    expect_error(folder_ / "a.glb", {.collections = collections, .progress = [](double) { return false; }},
                 std::string(kCancelled));
}

}  // namespace
}  // namespace sightline::importers::gltf_writer_test
