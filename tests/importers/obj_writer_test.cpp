// Scenes written as OBJ and read back.
#include "sightline/importers/obj/obj_writer.h"

#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sightline/importers/import.h"

namespace sightline::importers::obj_writer_test {
namespace {

namespace fs = std::filesystem;
using core::dvec3;

class ObjWriter : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("sightline_obj_writer_") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::size_t files() const {
    return std::size_t(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  static std::string contents(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  /// Writes the scene below its root and reads it into `again_`.
  ObjWriteReport round_trip(const ObjWriteOptions& options = {}) {
    const auto written = write_obj(scene_, scene_.root(), folder_ / "a b.obj", options);
    EXPECT_TRUE(written) << written.error().message;
    again_ = core::Scene();
    const auto read = import_file(folder_ / "a b.obj", again_, again_.root(), {.copies = MeshCopies::kApart});
    EXPECT_TRUE(read) << read.error().message;
    if (read) {
      EXPECT_TRUE(read->warnings.empty()) << read->warnings[0].message;
    }
    return written.value_or(ObjWriteReport{});
  }
  /// Corners of an item's triangles in the world.
  static std::vector<dvec3> corners(const core::Scene& scene, core::ItemId item) {
    const core::Affine world = scene.state(item).world_from_item;
    const core::Mesh& mesh = scene.mesh(scene.mesh_of(item));
    std::vector<dvec3> out;
    for (const std::uint32_t i : mesh.indices) out.push_back(core::transform_point(world, dvec3(mesh.positions[i])));
    return out;
  }
  static double signed_volume(const std::vector<dvec3>& corners) {
    double sum = 0.0;
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
      sum += glm::dot(corners[i] - corners[0], glm::cross(corners[i + 1] - corners[0], corners[i + 2] - corners[0]));
    return sum / 6.0;
  }

  fs::path folder_;
  core::Scene scene_, again_;
};

core::Mesh random_mesh(std::mt19937& random, bool normals) {
  std::uniform_real_distribution<float> coordinate(-1.0f, 1.0f);
  core::Mesh mesh;
  for (int i = 0; i < 20; ++i) {
    mesh.positions.emplace_back(coordinate(random), coordinate(random), coordinate(random));
    if (normals) mesh.normals.push_back(glm::normalize(mesh.positions.back()));
  }
  for (std::uint32_t i = 0; i < 60; ++i) mesh.indices.push_back(i < 20 ? i : std::uint32_t(random() % 20));
  return mesh;
}

TEST_F(ObjWriter, MeshesComeBack) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> angle(-3.0, 3.0), far(-1e7, 1e7);
    scene_ = core::Scene();
    const core::NodeId part = scene_.add_node(scene_.root(), "part", core::translation({far(random), far(random), 3}));
    const core::MeshId mesh = scene_.add_mesh(random_mesh(random, seed % 2 == 0)).value();
    const double c = std::cos(angle(random)), s = std::sin(angle(random));
    for (int i = 0; i < 3; ++i) {
      core::Affine placement = core::translation({double(i), 0.1, -0.2});
      placement.linear = core::dmat3(c, s, 0, -s, c, 0.3, 0, 0, i == 2 ? -1 : 1);  // the last one is mirrored
      const core::NodeId node = scene_.add_node(part, "item " + std::to_string(i));
      scene_.add_mesh_instance(node, mesh, placement,
                               scene_.add_material({.name = "paint", .colour = {0.1f * float(i), 0.5f, 1.0f}}));
    }
    const ObjWriteReport report = round_trip();
    EXPECT_EQ(report.items[std::size_t(core::Kind::kMesh)], 3u);
    EXPECT_EQ(report.triangles, 60u);
    EXPECT_EQ(report.vertices, 60u);
    EXPECT_EQ(report.bytes, fs::file_size(folder_ / "a b.obj") + fs::file_size(folder_ / "a_b.mtl"));
    ASSERT_EQ(again_.item_count(), 3u);
    for (core::ItemId i{0}; to_index(i) < 3; ++i) {
      EXPECT_EQ(again_.name(again_.node_of(i)), "part/item " + std::to_string(to_index(i)));
      const core::Material& look = again_.material(again_.item_material(i));
      EXPECT_EQ(look.colour, scene_.material(scene_.item_material(i)).colour);
      EXPECT_EQ(look.name, to_index(i) == 0 ? "paint" : "paint_" + std::to_string(to_index(i)));
      std::vector<dvec3> before = corners(scene_, i), after = corners(again_, i);
      ASSERT_EQ(before.size(), after.size());
      if (to_index(i) == 2)
        for (std::size_t k = 0; k < before.size(); k += 3) std::swap(before[k + 1], before[k + 2]);
      for (std::size_t k = 0; k < before.size(); ++k) ASSERT_LE(glm::length(before[k] - after[k]), 1e-6);
      EXPECT_EQ(again_.mesh(again_.mesh_of(i)).normals.empty(), seed % 2 == 1);
    }
  }
}

TEST_F(ObjWriter, DigitsOfFarCoordinatesStay) {
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0.0001f, 0, 0}, {0, 0.0001f, 0}};
  mesh.indices = {0, 1, 2};
  scene_.add_mesh_instance(scene_.root(), scene_.add_mesh(mesh).value(),
                           core::translation({1e7 + 0.1, -2e7 / 3.0, 0.0}));
  round_trip();
  const std::vector<dvec3> before = corners(scene_, core::ItemId{0}), after = corners(again_, core::ItemId{0});
  for (int k = 0; k < 3; ++k) EXPECT_LE(glm::length(before[std::size_t(k)] - after[std::size_t(k)]), 4e-9);
}

TEST_F(ObjWriter, PrimitivesKeepTheTolerance) {
  std::vector<core::Primitive> primitives = {core::Cylinder{0.5f, 20.0f},
                                             core::Sphere{3.0f},
                                             core::CircularTorus{2, 0.5f, 3},
                                             core::SphericalDish{2, 0.5f},
                                             core::EllipticalDish{2, 0.5f},
                                             core::Box{1, 2, 3},
                                             core::Snout{1, 0.3f, 2, 0.2f, 0, 0, 0, 0, 0},
                                             core::RectangularTorus{1, 2, 0.5f, 2},
                                             core::Pyramid{1, 1, 0.5f, 0.5f, 0, 0, 2}};
  for (const core::Primitive& primitive : primitives)
    for (const double tolerance : {0.1, 0.01, 0.001}) {
      SCOPED_TRACE(testing::Message() << core::name_of(core::kind_of(primitive)) << " " << tolerance);
      scene_ = core::Scene();
      core::Affine placement;
      placement.linear = 2.0 * core::dmat3(1.0);
      scene_.add_primitive(scene_.root(), primitive, placement);
      const ObjWriteReport report = round_trip({.tolerance = tolerance});
      EXPECT_EQ(report.items[std::size_t(core::kind_of(primitive))], 1u);
      EXPECT_LE(report.largest_chord_error, tolerance);
      EXPECT_GT(signed_volume(corners(again_, core::ItemId{0})), 0.0);
    }
}

TEST_F(ObjWriter, ChordErrorIsThatOfTheSegments) {
  // The triangles' distance from the axis, measured on what was written: at mid-segment it is smallest.
  for (const double radius : {0.01, 1.0, 300.0}) {
    scene_ = core::Scene();
    scene_.add_primitive(scene_.root(), core::Cylinder{float(radius), 50.0f});
    const ObjWriteReport report = round_trip({.tolerance = 0.002});
    double error = 0.0;
    const std::vector<dvec3> points = corners(again_, core::ItemId{0});
    for (std::size_t i = 0; i < points.size(); i += 3)
      for (std::size_t k = 0; k < 3; ++k) {
        const dvec3 a = points[i + k], b = points[i + (k + 1) % 3], m = 0.5 * (a + b);
        if (std::abs(a.z - b.z) < 1.0) continue;  // edges of caps
        error = std::max(error, radius - std::hypot(m.x, m.y));
      }
    EXPECT_NEAR(report.largest_chord_error, error, 1e-3 * error + 1e-7 * radius);  // the mesh is in float
    EXPECT_LE(report.largest_chord_error, 0.002);
  }
}

TEST_F(ObjWriter, TooFineAToleranceIsReported) {
  scene_.add_primitive(scene_.root(), core::Cylinder{1000.0f, 1.0f});
  const ObjWriteReport report = round_trip({.tolerance = 1e-6});
  EXPECT_NEAR(report.largest_chord_error, 1000.0 * (1.0 - std::cos(std::numbers::pi / kObjMostSegments)), 1e-5);
}

TEST_F(ObjWriter, NamesAndMaterials) {
  const core::MaterialId red = scene_.add_material({.name = "signal red\n", .colour = {1, 0, 0}, .alpha = 0.25f});
  const core::NodeId top = scene_.add_node(scene_.root(), "unit 1");
  const core::NodeId plain = scene_.add_node(top), painted = scene_.add_node(top, "line\nbreak"),
                     bare = scene_.add_node(top, "bare");
  scene_.set_material(painted, red);
  scene_.add_primitive(plain, core::Box{1, 1, 1});
  scene_.add_primitive(painted, core::Box{1, 1, 1});
  scene_.add_primitive(bare, core::Box{1, 1, 1});
  round_trip();
  ASSERT_EQ(again_.item_count(), 3u);
  EXPECT_EQ(again_.name(again_.node_of(core::ItemId{0})), "unit 1/#0");
  EXPECT_EQ(again_.name(again_.node_of(core::ItemId{1})), "unit 1/line_break");
  EXPECT_EQ(again_.name(again_.node_of(core::ItemId{2})), "unit 1/bare");
  EXPECT_FALSE(again_.item_material(core::ItemId{0}).valid());
  const core::Material& look = again_.material(again_.item_material(core::ItemId{1}));
  EXPECT_EQ(look.name, "signal_red_");
  EXPECT_EQ(look.colour, core::vec3(1, 0, 0));
  EXPECT_EQ(look.alpha, 0.25f);
  EXPECT_EQ(again_.material(again_.item_material(core::ItemId{2})).colour, core::Material{}.colour);
}

TEST_F(ObjWriter, WhatIsHiddenOrEmptyIsLeftOut) {
  const core::NodeId volumes = scene_.add_node(scene_.root(), "volumes"), off = scene_.add_node(scene_.root(), "off");
  scene_.set_layers(volumes, core::kLayerObstruction);
  scene_.set_visible(off, false);
  scene_.add_primitive(volumes, core::Box{1, 1, 1});
  scene_.add_primitive(off, core::Box{1, 1, 1});
  scene_.add_primitive(scene_.root(), core::Sphere{0});
  scene_.add_primitive(scene_.root(), core::Line{-1, 2});
  const auto report = write_obj(scene_, scene_.root(), folder_ / "a.obj");
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->left_out, 3u);
  EXPECT_EQ(report->items[std::size_t(core::Kind::kLine)], 1u);
  EXPECT_EQ(contents(folder_ / "a.obj"), "# metres, z up\no \nv -1 0 0\nv 2 0 0\nl 1 2\n");
  EXPECT_EQ(files(), 1u);  // no material, no library
}

TEST_F(ObjWriter, CancelAndFailureLeaveWhatWasThere) {
  std::ofstream(folder_ / "a.obj") << "old";
  const core::MaterialId material = scene_.add_material({.name = "m"});
  for (int i = 0; i < 100; ++i) scene_.add_primitive(scene_.root(), core::Sphere{1}, {}, material);
  double last = -1.0;
  const auto cancelled = write_obj(scene_, scene_.root(), folder_ / "a.obj", {.progress = [&](double share) {
                                     EXPECT_GT(share, last);
                                     last = share;
                                     return share < 0.5;
                                   }});
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().message, kCancelled);
  EXPECT_EQ(last, 0.5);
  EXPECT_EQ(contents(folder_ / "a.obj"), "old");
  EXPECT_EQ(files(), 1u);
  for (const double bad : {0.0, -1.0, double(NAN), double(INFINITY)})
    EXPECT_FALSE(write_obj(scene_, scene_.root(), folder_ / "a.obj", {.tolerance = bad}));
  EXPECT_FALSE(write_obj(scene_, scene_.root(), folder_ / "a.mtl"));
  const auto unwritable = write_obj(scene_, scene_.root(), folder_ / "a.obj" / "b.obj");
  ASSERT_FALSE(unwritable);
  EXPECT_NE(unwritable.error().message.find("b.obj"), std::string::npos);
  EXPECT_FALSE(write_obj(scene_, scene_.root(), folder_));
  EXPECT_EQ(files(), 1u);
}

TEST_F(ObjWriter, ToleranceHoldsInTheWorld) {
  const auto triangles = [&](const core::dmat3& linear, double tolerance) {
    scene_ = core::Scene();
    scene_.add_primitive(scene_.root(), core::Cylinder{1, 2}, {linear, {}});
    return round_trip({.tolerance = tolerance}).triangles;
  };
  const std::uint64_t fine = triangles(core::dmat3(1.0), 1e-4), coarse = triangles(core::dmat3(1.0), 1e-2);
  EXPECT_GT(fine, 5 * coarse);
  EXPECT_EQ(triangles(core::dmat3(100.0), 1e-2), fine);
  EXPECT_EQ(triangles(core::dmat3(0.01), 1e-4), coarse);
  // Stretched along a direction between the axes: no fewer than where all is stretched as much.
  const core::dmat3 slanted = core::dmat3(1.0) + 99.0 / 2.0 * core::dmat3(1, 1, 0, 1, 1, 0, 0, 0, 0);
  EXPECT_GE(triangles(slanted, 1e-2), fine);
}

TEST_F(ObjWriter, NormalsGoWithTheSurface) {
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.indices = {0, 1, 2};
  const core::MeshId bare = scene_.add_mesh(mesh).value();
  mesh.normals = {{0, 0, 1}, glm::normalize(core::vec3(1, 0, 1)), {0, 0, 0}};
  const core::MeshId with_normals = scene_.add_mesh(mesh).value();
  const core::NodeId top = scene_.add_node(scene_.root(), "top"), a = scene_.add_node(top), b = scene_.add_node(top);
  scene_.add_mesh_instance(a, bare, {core::dmat3(-1.0), {}});
  scene_.add_mesh_instance(b, with_normals, {core::dmat3(2, 0, 0, 0, 1, 0, 0, 0, 1), {}});
  scene_.add_mesh_instance(b, with_normals, {core::dmat3(1, 0, 0, 0, 1, 0, 0, 0, -1), {}});
  round_trip();
  EXPECT_EQ(contents(folder_ / "a b.obj").find("-0 "), std::string::npos);
  std::vector<core::vec3> normals;
  std::vector<std::string> names;
  for (core::ItemId i{0}; to_index(i) < again_.item_slots(); ++i) {
    names.push_back(std::string(again_.name(again_.node_of(i))));
    const core::Mesh& read = again_.mesh(again_.mesh_of(i));
    if (read.normals.empty()) continue;
    for (const std::uint32_t corner : read.indices) normals.push_back(read.normals[corner]);
  }
  EXPECT_EQ(names.front(), "top/#0");
  EXPECT_EQ(names.back(), "top/#1");
  const core::vec3 stretched = glm::normalize(core::vec3(0.5f, 0, 1)), mirrored = glm::normalize(core::vec3(1, 0, -1));
  const core::vec3 up(0, 0, 1);
  // Without a direction: any. The mirrored triangle runs the other way round.
  const std::vector<core::vec3> expected = {up, stretched, up, -up, up, mirrored};
  ASSERT_EQ(normals.size(), 6u);
  for (const core::vec3& wanted : expected)
    EXPECT_TRUE(std::any_of(normals.begin(), normals.end(),
                            [&](const core::vec3& n) { return glm::distance(n, wanted) < 1e-6f; }))
        << wanted.x << " " << wanted.y << " " << wanted.z;
  for (const core::vec3& n : normals) EXPECT_NEAR(glm::length(n), 1.0f, 1e-6f);
}

}  // namespace
}  // namespace sightline::importers::obj_writer_test
