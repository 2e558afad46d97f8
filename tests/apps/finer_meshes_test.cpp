// Meshes that get finer as a view comes nearer: how far their facets lie off the shaft, in pixels, and what they become
// again.
#include "sightline/apps/common/finer_meshes.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/mesh_extras.h"
#include "sightline/lod/finer_mesh.h"

namespace sightline::tests::finer_meshes_test {
namespace {

constexpr int kWidth = 800, kHeight = 600;
constexpr double kLength = 4.0;

/// A shaft of radius 1 around z.
core::Mesh shaft(int sides) {
  core::Mesh mesh;
  for (int i = 0; i <= sides; ++i) {
    const double a = 2.0 * std::numbers::pi * (i % sides) / sides;
    for (const double z : {0.0, kLength}) mesh.positions.emplace_back(std::cos(a), std::sin(a), z);
  }
  for (std::uint32_t i = 0; i < 2 * std::uint32_t(sides); i += 2)
    for (const std::uint32_t corner : {i, i + 2, i + 1, i + 1, i + 2, i + 3}) mesh.indices.push_back(corner);
  core::MeshExtras extras;
  extras.surfaces = std::make_shared<const std::vector<core::MeshSurface>>(
      1, core::MeshSurface{.kind = core::MeshSurface::Kind::kCylinder,
                           .end_triangle = std::uint32_t(2 * sides),
                           .radius = 1.0,
                           .gap = 1e-6});
  mesh.extras = core::MeshExtrasSlot(std::move(extras));
  return mesh;
}

class FinerMeshes : public testing::Test {
 protected:
  FinerMeshes() {
    mesh_ = scene_.add_mesh(shaft(30)).value();
    for (int i = 0; i < 3; ++i)
      items_.push_back(scene_.add_mesh_instance(scene_.root(), mesh_, core::translation({5.0 * i, 0, 0})));
    plain_ = scene_.add_mesh(core::Mesh{"", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}, {0, 1, 2}, {}, {}}).value();
    scene_.add_mesh_instance(scene_.root(), plain_);
    EXPECT_TRUE(scene_.commit());
  }
  static core::View from(double distance) {
    return *core::View::perspective({{0, -1.0 - distance, 2}, {0, 0, 2}, {0, 0, 1}}, 0.7, double(kWidth) / kHeight,
                                    0.01);
  }
  /// Pixels of a metre of the nearest part of the first shaft.
  static double pixels_per_metre(double distance) { return 0.5 * kHeight / std::tan(0.35) / distance; }
  /// Whether meshes have been exchanged for a view from there.
  bool follow(double distance) {
    const bool began = finer_.begin(core::Snapshot(scene_), from(distance), kWidth, kHeight);
    EXPECT_EQ(began, finer_.active());
    const bool changed = finer_.finish(scene_);
    EXPECT_TRUE(scene_.commit());
    return changed;
  }
  const core::Mesh& mesh_of(std::size_t item) const { return scene_.mesh(scene_.mesh_of(items_[item])); }

  core::Scene scene_;
  core::MeshId mesh_, plain_;
  std::vector<core::ItemId> items_;
  apps::FinerMeshes finer_;
};

TEST_F(FinerMeshes, KeepFacetsBelowHalfAPixel) {
  std::size_t triangles = 0;
  for (const double distance : {30.0, 3.0, 2.9, 0.5, 0.1, 0.02}) {
    SCOPED_TRACE(distance);
    const double before = lod::facet_gap(mesh_of(0)) * pixels_per_metre(distance);
    EXPECT_EQ(follow(distance), before > 0.5) << before << " pixels";
    const double gap = lod::facet_gap(mesh_of(0)) * pixels_per_metre(distance);
    EXPECT_LE(gap, 0.5);
    EXPECT_GE(mesh_of(0).indices.size(), triangles);
    triangles = mesh_of(0).indices.size();
    EXPECT_FALSE(follow(distance)) << "again";
    for (const core::ItemId item : items_) EXPECT_EQ(scene_.mesh_of(item), scene_.mesh_of(items_[0])) << "shared";
    EXPECT_TRUE(scene_.contains(mesh_)) << "to come back to";
    EXPECT_LE(finer_.count(), 1u) << "others are removed";
  }
  EXPECT_EQ(finer_.count(), 1u);
  EXPECT_FALSE(follow(30.0)) << "farther away they stay";
}

TEST_F(FinerMeshes, ComeBackToWhatTheyWere) {
  ASSERT_TRUE(follow(1.0));
  ASSERT_TRUE(follow(0.05));
  const core::MeshId finest = scene_.mesh_of(items_[0]);
  EXPECT_TRUE(finer_.coarse_again(scene_));
  EXPECT_TRUE(scene_.commit());
  for (const core::ItemId item : items_) EXPECT_EQ(scene_.mesh_of(item), mesh_);
  EXPECT_FALSE(scene_.contains(finest));
  EXPECT_FALSE(finer_.coarse_again(scene_));
  EXPECT_TRUE(follow(0.05)) << "and once more";
}

TEST_F(FinerMeshes, AreOfWhatTheViewShows) {
  core::View away = from(0.05);
  const auto looks_away =
      core::View::perspective({{0, -1.05, 2}, {0, -9, 2}, {0, 0, 1}}, 0.7, double(kWidth) / kHeight, 0.01);
  EXPECT_FALSE(finer_.begin(core::Snapshot(scene_), *looks_away, kWidth, kHeight));
  away.sections = {{{0, 1, 0}, 0.0}};  // through all shafts
  EXPECT_TRUE(finer_.begin(core::Snapshot(scene_), away, kWidth, kHeight));
  finer_.forget();
  EXPECT_FALSE(finer_.active());
  EXPECT_FALSE(finer_.finish(scene_));
}

}  // namespace
}  // namespace sightline::tests::finer_meshes_test
