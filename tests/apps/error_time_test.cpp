// What error against time is measured with: sample errors against a twin that tries all pairs, rays of a field, and the
// tessellated scene.
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sightline/apps/bench/error_time/field.h"
#include "sightline/apps/common/tessellated_scene.h"

namespace sightline::bench::error_time_test {
namespace {

using apps::tessellated;
using core::dvec3;
using core::Kind;
using core::vec3;

void set(SampleImage& image, int x, int y, double depth, const vec3& normal = {0, 0, 1}) {
  const std::size_t i = std::size_t(y) * std::size_t(image.width) + std::size_t(x);
  image.depth[i] = depth;
  image.normals[i] = normal;
}

SampleImage disc(double x0, double y0, double radius, double depth) {
  SampleImage image(64, 48);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (std::hypot(x - x0, y - y0) <= radius) set(image, x, y, depth);
  return image;
}

// --- errors ----------------------------------------------------------------------------------------------------------

TEST(SampleErrors, EqualImagesHaveNone) {
  const SampleImage image = disc(30, 24, 12, 5.0);
  const SampleErrors e = compare_samples(image, image, 3);
  EXPECT_GT(e.hits, 400u);
  EXPECT_EQ(e.wrong(), 0u);
  EXPECT_EQ(e.depth.max, 0.0);
  EXPECT_EQ(e.normal.max, 0.0);
  EXPECT_EQ(e.silhouette_mean, 0.0);
  EXPECT_EQ(e.silhouette_max, 0.0);
}

TEST(SampleErrors, AreThoseOfDepthAndNormal) {
  SampleImage reference(100, 1), image(100, 1);
  for (int x = 0; x < 100; ++x) {
    set(reference, x, 0, 4.0);
    const float angle = x < 98 ? 1e-4f : 0.5f;
    set(image, x, 0, x < 98 ? 4.0 : 5.0, {std::sin(angle), 0, std::cos(angle)});
  }
  const SampleErrors e = compare_samples(reference, image, 1);
  EXPECT_NEAR(e.depth.mean, 0.005, 1e-12);
  EXPECT_EQ(e.depth.p99, 0.25);
  EXPECT_EQ(e.depth.max, 0.25);
  EXPECT_NEAR(e.normal.max, glm::degrees(0.5), 1e-4);
  EXPECT_NEAR(e.normal.mean, glm::degrees(0.98e-4 + 0.01), 1e-5);
}

TEST(SampleErrors, AShiftedDiscIsAsFarAsItWasShifted) {
  const SampleErrors e = compare_samples(disc(30, 24, 12, 5.0), disc(36, 24, 12, 5.0), 2);
  EXPECT_EQ(e.silhouette_max, 3.0);  // six samples, two to a pixel
  EXPECT_GT(e.silhouette_mean, 1.5);
  EXPECT_LT(e.silhouette_mean, 2.5);
  EXPECT_EQ(e.false_hits, e.false_misses);
  EXPECT_GT(e.false_hits, 100u);
}

TEST(SampleErrors, WhatIsNotThereIsAsFarAsCanBe) {
  const SampleErrors e = compare_samples(disc(30, 24, 5, 5.0), SampleImage(64, 48), 1);
  EXPECT_EQ(e.silhouette_max, kFarthestSilhouette);
  EXPECT_EQ(e.false_misses, e.hits);
}

/// Mean and largest distance, from all pairs.
std::array<double, 2> silhouette_twin(const SampleImage& a, const SampleImage& b) {
  const auto boundary = [](const SampleImage& image) {
    std::vector<std::array<int, 2>> points;
    const auto hit = [&](int x, int y) {
      return x >= 0 && y >= 0 && x < image.width && y < image.height &&
             image.hit(std::size_t(y) * std::size_t(image.width) + std::size_t(x));
    };
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        if (hit(x, y) && !(hit(x - 1, y) && hit(x + 1, y) && hit(x, y - 1) && hit(x, y + 1))) points.push_back({x, y});
    return points;
  };
  const auto of_a = boundary(a), of_b = boundary(b);
  double sum = 0.0, most = 0.0;
  for (const auto& [from, to] : {std::pair(&of_a, &of_b), std::pair(&of_b, &of_a)})
    for (const auto& p : *from) {
      double best = kFarthestSilhouette;
      for (const auto& q : *to) best = std::min(best, std::hypot(p[0] - q[0], p[1] - q[1]));
      sum += best;
      most = std::max(most, best);
    }
  return {sum / double(of_a.size() + of_b.size()), most};
}

TEST(SampleErrors, SilhouettesAgreeWithAllPairs) {
  for (int seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random{std::uint32_t(seed)};
    const auto any = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
    SampleImage a = disc(any(5, 60), any(5, 40), any(0.5, 20), 1.0),
                b = disc(any(5, 60), any(5, 40), any(0.5, 20), 1.0);
    for (int i = 0; i < seed; ++i) set(i % 2 ? a : b, int(any(0, 64)), int(any(0, 48)), 1.0);
    const SampleErrors e = compare_samples(a, b, 1);
    const auto [mean, most] = silhouette_twin(a, b);
    EXPECT_NEAR(e.silhouette_mean, mean, 1e-9);
    EXPECT_NEAR(e.silhouette_max, most, 1e-9);
  }
}

// --- fields ----------------------------------------------------------------------------------------------------------

TEST(ErrorField, ItemsAreSideBySideAndWithinTheImage) {
  for (const Kind kind : measured_kinds()) {
    SCOPED_TRACE(core::name_of(kind));
    for (const FieldSize& size : {FieldSize{30, 8, 8, 1}, FieldSize{288, 2, 1, 1}}) {
      const Field field = make_field(kind, size, 640, 480, 7);
      ASSERT_EQ(field.items.size(), std::size_t(size.columns * size.rows));
      std::vector<bool> taken(640 * 480);
      for (const ItemRays& item : field_rays(field, 640, 480)) {
        const double ball = 0.25 * std::numbers::pi * size.pixels * size.pixels;
        EXPECT_GT(double(item.rays.size()), ball);
        EXPECT_LT(double(item.rays.size()), 1.25 * ball) << "perspective and the margin make it somewhat larger";
        for (const std::uint32_t sample : item.samples) {
          ASSERT_FALSE(taken[sample]);
          taken[sample] = true;
          ASSERT_TRUE(sample >= 640 && sample < 640 * 479 && sample % 640 > 0 && sample % 640 < 639);
        }
      }
    }
  }
}

/// Points at which rays hit lie on the item, seen from the eye at their depth.
TEST(ErrorField, DepthsAndNormalsOfABall) {
  const Field field = make_field(Kind::kSphere, {144, 2, 1, 1}, 320, 240, 3);
  SampleImage image(320, 240);
  cast(field, field_rays(field, 320, 240), 0, image);
  int hits = 0;
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      const std::size_t i = std::size_t(y) * 320 + std::size_t(x);
      if (!image.hit(i)) continue;
      ++hits;
      const core::dmat4 clip = field.view.clip_from_eye();
      const dvec3 p = image.depth[i] * dvec3((2.0 * (x + 0.5) / 320 - 1.0) / clip[0][0],
                                             (1.0 - 2.0 * (y + 0.5) / 240) / clip[1][1], -1.0);
      const FieldItem& item = field.items[x < 160 ? 0 : 1];
      const dvec3 centre(field.view.eye_from_world() * core::dvec4(item.centre, 1.0));
      ASSERT_NEAR(glm::length(p - centre), 0.5, 2e-3);  // the ball was measured with 64 segments
      ASSERT_GT(glm::dot(dvec3(image.normals[i]), glm::normalize(p - centre)), 1.0 - 1e-6);
    }
  EXPECT_GT(hits, 30000);
}

// --- the tessellated scene -------------------------------------------------------------------------------------------

class TessellatedScene : public testing::Test {
 protected:
  TessellatedScene() {
    core::Mesh triangle;
    triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    triangle.indices = {0, 1, 2};
    const core::MaterialId red = scene.add_material({"red", {1, 0, 0}, 0.5f, 7});
    scene.set_transform(scene.root(), core::translation({1e6, 2e6, 3.0}));
    scene.set_material(scene.root(), red);
    const core::NodeId a = scene.add_node(scene.root(), "a"), b = scene.add_node(a, "b", core::translation({0, 0, 9}));
    const core::NodeId unnamed = scene.add_node(a), hidden = scene.add_node(scene.root(), "hidden");
    scene.add_node(unnamed, "empty");
    scene.set_visible(hidden, false);
    scene.set_layers(b, 4);
    scene.set_attribute(b, "key", "value");
    scene.add_primitive(b, core::Cylinder{1, 2}, {}, scene.add_material({"blue", {0, 0, 1}, 1.0f, 9}));
    const core::ItemId gone = scene.add_primitive(a, core::Sphere{1});
    scene.add_primitive(hidden, core::Cylinder{1, 2}, core::translation({4, 5, 6}));
    scene.add_primitive(unnamed, core::Cylinder{1, 3});
    scene.add_primitive(unnamed, core::Line{-1, 1});
    const core::MeshId mesh = scene.add_mesh(triangle).value();
    scene.add_mesh_instance(a, mesh);
    scene.set_visible(scene.add_mesh_instance(a, mesh, core::translation({7, 0, 0})), false);
    scene.remove_item(gone);
    EXPECT_TRUE(scene.commit());
  }
  core::Scene scene;
};

TEST_F(TessellatedScene, KeepsEverythingButTheShapes) {
  core::Scene made = tessellated(scene, 64);
  ASSERT_TRUE(made.commit());
  EXPECT_EQ(made.node_count(), scene.node_count());
  EXPECT_EQ(made.item_count(), scene.item_count());
  ASSERT_EQ(made.item_slots(), scene.item_slots());
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item) {
    SCOPED_TRACE(to_index(item));
    ASSERT_EQ(made.contains_item(item), scene.contains_item(item));
    if (!scene.contains_item(item)) continue;
    EXPECT_EQ(made.path(made.node_of(item)), scene.path(scene.node_of(item)));
    EXPECT_EQ(made.attributes(made.node_of(item)), scene.attributes(scene.node_of(item)));
    const core::Scene::ItemState was = scene.state(item), is = made.state(item);
    EXPECT_EQ(is.layers, was.layers);
    ASSERT_EQ(is.material == core::kNone, was.material == core::kNone);
    EXPECT_EQ(made.material(made.material_at(is.material)).code, scene.material(scene.material_at(was.material)).code);
    EXPECT_EQ(is.world_from_item.origin, was.world_from_item.origin);
    EXPECT_EQ(is.world_from_item.linear, was.world_from_item.linear);
    const core::AabbD box = scene.bounds_under(item, {}), other = made.bounds_under(item, {});
    EXPECT_LT(glm::length(box.min - other.min) + glm::length(box.max - other.max), 0.01);
    EXPECT_EQ(made.kind(item), scene.kind(item) == Kind::kLine ? Kind::kLine : Kind::kMesh);
  }
}

TEST_F(TessellatedScene, EqualShapesShareAMesh) {
  const core::Scene made = tessellated(scene, 8);
  EXPECT_EQ(made.mesh_of(core::ItemId{0}), made.mesh_of(core::ItemId{2})) << "equal cylinders";
  EXPECT_NE(made.mesh_of(core::ItemId{0}), made.mesh_of(core::ItemId{3}));
  EXPECT_EQ(made.mesh_of(core::ItemId{5}), made.mesh_of(core::ItemId{6})) << "instances of one mesh";
  EXPECT_EQ(made.mesh_slots(), 3u);
  EXPECT_EQ(made.mesh(made.mesh_of(core::ItemId{0})).indices.size() / 3, 8u * 2 + 2 * (8 - 2));
}

/// Millimetres and metres give the same triangles for the same tolerance in the world, and one mesh.
TEST_F(TessellatedScene, KeepsATolerance) {
  core::Scene spheres;
  core::Affine metres, millimetres;
  millimetres.linear = core::dmat3(1e-3);
  const core::NodeId node = spheres.add_node(spheres.root());
  spheres.add_primitive(node, core::Sphere{2.0f}, metres);
  spheres.add_primitive(node, core::Sphere{2000.0f}, millimetres);
  spheres.add_primitive(node, core::Sphere{2000.0f}, millimetres);
  ASSERT_TRUE(spheres.commit());
  std::size_t coarser = 0;
  for (const double tolerance : {0.1, 0.01, 0.001}) {
    const core::Scene made = apps::tessellated_within(spheres, tolerance);
    EXPECT_EQ(made.mesh_slots(), 2u);
    const core::Mesh& mesh = made.mesh(made.mesh_of(core::ItemId{0}));
    EXPECT_EQ(mesh.indices, made.mesh(made.mesh_of(core::ItemId{1})).indices);
    EXPECT_GT(mesh.indices.size(), coarser);
    coarser = mesh.indices.size();
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      dvec3 centre(0.0);
      for (std::size_t c = 0; c < 3; ++c) centre += dvec3(mesh.positions[mesh.indices[i + c]]) / 3.0;
      EXPECT_GE(glm::length(centre), 1.0 - tolerance);
    }
  }
}

}  // namespace
}  // namespace sightline::bench::error_time_test
