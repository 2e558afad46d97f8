// Fixture for tests of the glTF reader: what it makes of a file, and what it says of damage.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/importers/gltf/internal/gltf_reader.h"
#include "sightline/tests/importers/gltf_bytes.h"

namespace sightline::tests {

class GltfReading : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) / (std::string("sightline_gltf_") + test->name()) / "models";
    std::filesystem::remove_all(folder_.parent_path());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_.parent_path()); }

  core::Expected<importers::ImportReport> read(std::span<const std::byte> bytes, bool lenient = false) {
    scene_ = core::Scene();
    auto report = importers::read_gltf(bytes, folder_ / "model.glb", scene_, scene_.root(), {.lenient = lenient});
    if (report) {
      EXPECT_TRUE(scene_.commit());
    } else {
      EXPECT_EQ(scene_.node_count(), 1u);
      EXPECT_EQ(scene_.item_slots() + scene_.mesh_slots() + scene_.material_slots(), 0u);
    }
    return report;
  }
  core::Expected<importers::ImportReport> read(const GltfBytes& file, bool lenient = false) {
    return read(file.glb(), lenient);
  }
  core::Expected<importers::ImportReport> read_text(const std::string& text, bool lenient = false) {
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

  /// A strict read, which must not fail, and its first warning.
  void expect_warning(const GltfBytes& file, const std::string& message) {
    const auto strict = read(file);
    ASSERT_TRUE(strict) << strict.error().message;
    ASSERT_FALSE(strict->warnings.empty()) << message;
    EXPECT_EQ(strict->warnings[0].message.find(message), 0u) << strict->warnings[0].message;
  }

  core::NodeId find(std::string_view name) const {
    core::NodeId found;
    scene_.for_each_node(scene_.root(), [&](core::NodeId node, auto&&...) {
      if (scene_.name(node) == name) found = node;
    });
    return found;
  }
  /// World positions of an item's corners, in order.
  std::vector<core::dvec3> corners(core::ItemId item) const {
    const core::Affine world = scene_.state(item).world_from_item;
    const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(item));
    std::vector<core::dvec3> all;
    for (const std::uint32_t i : mesh.indices)
      all.push_back(core::transform_point(world, core::dvec3(mesh.positions[i])));
    return all;
  }
  void expect_corners(core::ItemId item, const std::vector<core::dvec3>& expected, double tolerance = 1e-6) const {
    const auto found = corners(item);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i)
      EXPECT_LE(glm::length(found[i] - expected[i]), tolerance)
          << "corner " << i << ": " << found[i].x << " " << found[i].y << " " << found[i].z;
  }

  std::filesystem::path folder_;
  core::Scene scene_;
};

}  // namespace sightline::tests
