// Scenes written as STL and PLY, and read back.
#include <algorithm>
#include <array>
#include <fstream>
#include <numbers>

#include <gtest/gtest.h>

#include "sightline/core/surface_area.h"
#include "sightline/importers/import.h"
#include "sightline/importers/write_file.h"

namespace sightline::importers::triangle_writers_test {
namespace {

namespace fs = std::filesystem;
using core::dvec3;
using Triangles = std::vector<std::array<dvec3, 3>>;

class TriangleWriters : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    const core::MaterialId red = scene_.add_material({"red", {1.0f, 0.0f, 0.5f}});
    const core::NodeId node = scene_.add_node(scene_.root(), "node", core::translation({100.0, -50.0, 7.0}));
    scene_.add_primitive(node, core::Box{1, 2, 3}, {}, red);
    core::Affine mirrored;
    mirrored.linear[0] = -mirrored.linear[0];
    mirrored.origin = {0, 5, 0};
    scene_.add_primitive(node, core::Cylinder{0.5f, 2.0f}, mirrored);
    core::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    scene_.add_mesh_instance(node, scene_.add_mesh(mesh).value(), core::translation({9, 9, 9}));
    hidden_ = scene_.add_primitive(node, core::Sphere{1});
    scene_.set_visible(hidden_, false);
    scene_.add_primitive(node, core::Line{0, 1});
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path file() const { return folder_ / (std::string("a ü") + GetParam()); }
  /// All triangles of a scene in the world.
  static Triangles triangles(const core::Scene& scene) {
    Triangles all;
    for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item) {
      const core::Affine world = scene.state(item).world_from_item;
      const core::Mesh& mesh = scene.mesh(scene.mesh_of(item));
      for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        auto& triangle = all.emplace_back();
        for (std::size_t k = 0; k < 3; ++k)
          triangle[k] = core::transform_point(world, dvec3(mesh.positions[mesh.indices[i + k]]));
      }
    }
    return all;
  }
  static double volume(const Triangles& triangles) {
    double sum = 0.0;
    for (const auto& [a, b, c] : triangles) sum += glm::dot(a - triangles[0][0], glm::cross(b - a, c - a)) / 6.0;
    return sum;
  }

  fs::path folder_ = fs::path(testing::TempDir()) / "sightline_triangle_writers";
  core::Scene scene_, again_;
  core::ItemId hidden_{};
};

TEST_P(TriangleWriters, ComeBackInPlaceAndFaceOutwards) {
  const auto written = write_file(scene_, scene_.root(), file(), {.tolerance = 1e-4});
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_EQ(written->left_out, 2u) << "what is hidden, and a line";
  EXPECT_EQ(written->bytes, fs::file_size(file()));
  const auto read = import_file(file(), again_, again_.root());
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(read->warnings.empty()) << read->warnings[0].message;
  const Triangles all = triangles(again_);
  EXPECT_EQ(all.size(), written->triangles->triangles);
  const core::AabbD box = again_.bounds(again_.root()), expected = scene_.bounds(scene_.root());
  EXPECT_LT(glm::length(box.max - dvec3(110, -40, 17)) + glm::length(box.min - dvec3(99.5, -51, 5.5)), 1e-3);
  EXPECT_FALSE(expected.empty());
  EXPECT_NEAR(volume(all), 6.0 + 0.5 * std::numbers::pi + 1.0 / 6.0, 2e-3);
}

TEST_P(TriangleWriters, AreWholeOrNotAtAll) {
  std::ofstream(file()) << "before";
  const auto stopped =
      write_file(scene_, scene_.root(), file(), {.progress = [](double share) { return share < 0.5; }});
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().message, kCancelled);
  EXPECT_EQ(fs::file_size(file()), 6u);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
  EXPECT_FALSE(write_file(scene_, scene_.root(), file(), {.tolerance = 0.0}));
  EXPECT_FALSE(write_file(scene_, scene_.root(), folder_ / "none" / (std::string("a") + GetParam())));
  const core::Scene empty;
  const auto nothing = write_file(empty, empty.root(), file());
  ASSERT_TRUE(nothing) << nothing.error().message;
  EXPECT_EQ(nothing->triangles->triangles, 0u);
}

INSTANTIATE_TEST_SUITE_P(Formats, TriangleWriters, testing::Values(".stl", ".ply"),
                         [](const auto& test) { return std::string(test.param + 1); });

/// Far positions keep their digits in PLY, and materials their colours.
TEST(PlyWriter, KeepsColoursAndDigits) {
  const fs::path file = fs::path(testing::TempDir()) / "sightline_far.ply";
  core::Scene scene, again;
  scene.add_primitive(scene.root(), core::Box{1, 1, 1}, core::translation({3e6, -5e6, 0.125}),
                      scene.add_material({"red", {1.0f, 0.0f, 0.5f}, 0.5f}));
  ASSERT_TRUE(write_file(scene, scene.root(), file));
  ASSERT_TRUE(import_file(file, again, again.root()));
  const core::AabbD box = again.bounds(again.root());
  EXPECT_LT(glm::length(box.min - dvec3(3e6 - 0.5, -5e6 - 0.5, -0.375)), 1e-6);
  bool found = false;
  for (std::size_t i = 0; i < again.material_slots(); ++i)
    if (const core::MaterialId id = again.material_at(i); id.valid())
      found = found || glm::length(again.material(id).colour - core::vec3(1.0f, 0.0f, 0.5f)) < 0.01f;
  EXPECT_TRUE(found);
  fs::remove(file);
}

}  // namespace
}  // namespace sightline::importers::triangle_writers_test
