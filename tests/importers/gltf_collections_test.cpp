// Plant models of parametric primitives: points of each primitive's surface, computed from the convention's own
// formulas, must lie on what was imported.
#include "sightline/importers/gltf/internal/gltf_collections.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "sightline/importers/gltf/internal/gltf_reader.h"
#include "sightline/tests/importers/gltf_bytes.h"
#include "sightline/tests/importers/triangle_distance.h"

namespace sightline::importers::gltf_collections_test {
namespace {

using core::dvec2;
using core::dvec3;
using tests::GltfBytes;
using Json = json::Value;

constexpr double kPi = 3.14159265358979323846;

/// How far a point is from the surface of an analytic primitive, both in its own coordinates; ends included, by their
/// planes and angles.
struct Distance {
  dvec3 p;
  static double outside(double value, double low, double high) { return std::max({low - value, value - high, 0.0}); }
  double angle_outside(double angle) const {
    double at = std::atan2(p.y, p.x);
    if (at < -1e-5) at += 2.0 * kPi;
    return glm::length(dvec2(p)) * outside(at, 0.0, angle);
  }
  double operator()(const core::Box& b) const {
    const dvec3 size(b.size_x, b.size_y, b.size_z), q = glm::abs(p) - 0.5 * size;
    return std::abs(std::max({q.x, q.y, q.z}));
  }
  double operator()(const core::Cylinder& c) const {
    const double r = glm::length(dvec2(p));
    if (c.height == 0) return std::max(std::abs(p.z), outside(r, 0.0, c.radius));
    return std::max(std::abs(r - c.radius), outside(p.z, -0.5 * c.height, 0.5 * c.height));
  }
  double operator()(const core::Snout& s) const {
    const double at = 0.5 + p.z / s.height;
    const dvec2 lean(s.offset_x, s.offset_y), centre = lean * (at - 0.5);
    const double r = s.bottom_radius + (s.top_radius - s.bottom_radius) * at;
    const dvec2 low = dvec2(p) + 0.5 * lean, high = dvec2(p) - 0.5 * lean;
    const double bottom =
        -0.5 * s.height + std::tan(double(s.bottom_shear_x)) * low.x + std::tan(double(s.bottom_shear_y)) * low.y;
    const double top =
        0.5 * s.height + std::tan(double(s.top_shear_x)) * high.x + std::tan(double(s.top_shear_y)) * high.y;
    return std::max(std::abs(glm::length(dvec2(p) - centre) - r), outside(p.z, bottom, top));
  }
  double operator()(const core::RectangularTorus& t) const {
    return std::max({outside(glm::length(dvec2(p)), t.inner_radius, t.outer_radius),
                     outside(p.z, -0.5 * t.height, 0.5 * t.height), angle_outside(t.angle)});
  }
  double operator()(const core::CircularTorus& t) const {
    return std::max(std::abs(std::hypot(glm::length(dvec2(p)) - t.major_radius, p.z) - t.tube_radius),
                    angle_outside(t.angle));
  }
  double operator()(const core::EllipticalDish& d) const {
    const double scale = std::hypot(glm::length(dvec2(p)) / d.base_radius, p.z / d.height);
    return std::max(std::abs(scale - 1.0) * std::min(d.base_radius, d.height), outside(p.z, 0.0, d.height));
  }
  double operator()(const core::SphericalDish& d) const {
    const double r = (double(d.base_radius) * d.base_radius + double(d.height) * d.height) / (2.0 * d.height);
    return std::max(std::abs(glm::length(p - dvec3(0, 0, d.height - r)) - r), outside(p.z, 0.0, d.height));
  }
  double operator()(const core::Sphere& s) const { return std::abs(glm::length(p) - 0.5 * s.diameter); }
  template <class Other>
  double operator()(const Other&) const {
    return 1e9;
  }
};

class GltfCollectionsTest : public testing::Test {
 protected:
  double real(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  float number(double low, double high) { return float(real(low, high)); }
  dvec3 direction() {
    for (;;) {
      const dvec3 v(real(-1, 1), real(-1, 1), real(-1, 1));
      const double length = glm::length(v);
      if (length > 0.1 && length < 1.0) return v / length;
    }
  }
  static dvec3 across(const dvec3& axis) {
    return glm::normalize(glm::cross(axis, std::abs(axis.z) < 0.7 ? dvec3(0, 0, 1) : dvec3(1, 0, 0)));
  }
  void column(const std::string& name, const std::string& type, const std::vector<float>& values) {
    attributes_[name] = file_.floats(values, type);
  }
  float scalar(const std::string& name, double value) {
    column(name, "SCALAR", {float(value)});
    return float(value);
  }
  /// Writes a vector and returns what the file then holds.
  dvec3 vector(const std::string& name, const dvec3& v) {
    column(name, "VEC3", {float(v.x), float(v.y), float(v.z)});
    return dvec3(core::vec3(v));
  }
  core::Affine matrix(const dvec3& scale) {
    const dvec3 x = direction(), y = across(x), z = glm::cross(x, y), at(real(-50, 50), real(-50, 50), real(-50, 50));
    const dvec3 columns[] = {x * scale.x, y * scale.y, z * scale.z, at};
    std::vector<float> values;
    for (int c = 0; c < 4; ++c) {
      for (int r = 0; r < 3; ++r) values.push_back(float(columns[c][r]));
      values.push_back(c == 3 ? 1.0f : 0.0f);
    }
    column("_instanceMatrix", "MAT4", values);
    core::Affine map;
    for (int c = 0; c < 3; ++c) map.linear[c] = dvec3(core::vec3(columns[c]));
    map.origin = dvec3(core::vec3(at));
    return map;
  }
  /// Imports the collection and returns the only item.
  void import(const std::string& kind) {
    file_.json["nodes"] = Json::array();
    file_.json["scenes"][0]["nodes"] = Json::array();
    column("_treeIndex", "SCALAR", {42.0f});
    attributes_["_color"] = file_.accessor<std::uint8_t>({255, 128, 0, 0}, "VEC4", true);  // writers leave the alpha 0
    file_.root({{"name", kind}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", attributes_}}}}}});
    scene_ = core::Scene();
    const auto report = read_gltf(file_.glb(), "plant.glb", scene_, scene_.root());
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_EQ(report->warnings.size(), report->degenerate) << report->warnings[0].message;
    ASSERT_EQ(scene_.item_count(), 1u);
    EXPECT_EQ(scene_.path(scene_.node_of(core::ItemId{0})), "plant.glb/42");
    const core::Material& material = scene_.material(scene_.item_material(core::ItemId{0}));
    EXPECT_EQ(material.colour, core::vec3(1.0f, 128 / 255.0f, 0.0f));
    EXPECT_EQ(material.alpha, 1.0f);
    attributes_ = Json::object();
    file_ = {};
  }
  double distance_of(const dvec3& world) {
    const core::Affine item = scene_.state(core::ItemId{0}).world_from_item;
    double distance = 1e9;
    if (int(scene_.kind(core::ItemId{0})) < core::kPrimitiveKindCount) {
      const dvec3 local = glm::inverse(item.linear) * (world - item.origin);
      const double stretch =
          std::max({glm::length(item.linear[0]), glm::length(item.linear[1]), glm::length(item.linear[2])});
      distance = stretch * std::visit(Distance{local}, scene_.primitive(core::ItemId{0}));
    } else {
      const core::Mesh& mesh = scene_.mesh(scene_.mesh_of(core::ItemId{0}));
      const auto at = [&](std::size_t i) {
        return core::transform_point(item, dvec3(mesh.positions[mesh.indices[i]]));
      };
      for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
        distance = std::min(distance, tests::distance_to_triangle(world, {at(i), at(i + 1), at(i + 2)}));
    }
    return distance;
  }
  void expect_on_surface(const dvec3& world, double size, double tolerance = 1e-6) {
    EXPECT_LE(distance_of(world), tolerance * size) << world.x << " " << world.y << " " << world.z;
  }
  /// Runs `body` with many seeds.
  template <class Body>
  void repeat(Body&& body) {
    for (unsigned seed = 0; seed < 60 && !HasFailure(); ++seed) {
      SCOPED_TRACE(testing::Message() << "seed " << seed);
      random_.seed(seed);
      body();
    }
  }

  std::mt19937 random_;
  GltfBytes file_;
  Json attributes_ = Json::object();
  core::Scene scene_;
};

TEST_F(GltfCollectionsTest, BoxesAndQuads) {
  repeat([&] {
    const core::Affine map = matrix({real(0.1, 5), real(0.1, 5), real(0.1, 5)});
    import("BoxCollection");
    EXPECT_EQ(scene_.kind(core::ItemId{0}), core::Kind::kBox);
    for (int i = 0; i < 20; ++i) {
      dvec3 p(real(-0.5, 0.5), real(-0.5, 0.5), real(-0.5, 0.5));
      p[i % 3] = i % 2 ? 0.5 : -0.5;
      expect_on_surface(core::transform_point(map, p), 5);
    }
    const core::Affine flat = matrix({real(0.1, 5), real(0.1, 5), 0.0});
    import("QuadCollection");
    for (int i = 0; i < 20; ++i)
      expect_on_surface(core::transform_point(flat, {real(-0.5, 0.5), real(-0.5, 0.5), 0.0}), 5);
  });
}

TEST_F(GltfCollectionsTest, CirclesAndRings) {
  repeat([&] {
    const core::Affine circle = matrix({2, 2, 0});
    import("CircleCollection");
    for (int i = 0; i < 20; ++i) {
      const double angle = real(0, 2 * kPi), r = real(0, 0.5);
      expect_on_surface(core::transform_point(circle, {r * std::cos(angle), r * std::sin(angle), 0.0}), 2);
    }
    const double thickness = scalar("_thickness", real(0.01, 1)), from = scalar("_angle", real(-3, 3)),
                 arc = scalar("_arcAngle", random_() % 3 == 0 ? 2 * kPi : real(0.1, 6));
    const core::Affine ring = matrix({real(1, 5), real(1, 5), 0});
    import("GeneralRingCollection");
    EXPECT_EQ(scene_.kind(core::ItemId{0}), core::Kind::kRectangularTorus);
    for (int i = 0; i < 20; ++i) {
      const double angle = from + real(0, arc), r = real(0.5 * (1 - thickness), 0.5);
      expect_on_surface(core::transform_point(ring, {r * std::cos(angle), r * std::sin(angle), 0.0}), 5);
    }
  });
}

TEST_F(GltfCollectionsTest, Cones) {
  repeat([&] {
    const dvec3 axis = direction(), side = across(axis);
    const dvec3 b = vector("_centerB", {real(-9, 9), real(-9, 9), real(-9, 9)});
    const dvec3 a = vector("_centerA", b + real(0.1, 10) * axis);
    const dvec3 x = glm::normalize(vector("_localXAxis", side));
    const dvec3 z = glm::normalize(a - b), y = glm::cross(z, x);
    const bool straight = random_() % 2, whole = random_() % 2;
    const double ra = scalar("_radiusA", real(0.1, 3)), rb = scalar("_radiusB", straight ? ra : real(0.1, 3));
    const double from = scalar("_angle", real(-3, 3)), arc = scalar("_arcAngle", whole ? 2 * kPi : real(0.5, 6));
    import("ConeCollection");
    using core::Kind;
    EXPECT_EQ(scene_.kind(core::ItemId{0}),
              whole ? (straight ? Kind::kCylinder : Kind::kSnout) : (straight ? Kind::kRectangularTorus : Kind::kMesh));
    for (int i = 0; i < 20; ++i) {
      const double t = real(0, 1), angle = from + real(0, arc), r = rb + (ra - rb) * t;
      expect_on_surface(b + t * (a - b) + r * (std::cos(angle) * x + std::sin(angle) * y), 10,
                        scene_.kind(core::ItemId{0}) == Kind::kMesh ? kFacetError : 1e-6);
    }
  });
}

TEST_F(GltfCollectionsTest, EccentricCones) {
  repeat([&] {
    const dvec3 n = glm::normalize(vector("_normal", direction()));
    const dvec3 b = vector("_centerB", {real(-9, 9), real(-9, 9), real(-9, 9)});
    const dvec3 a = vector("_centerA", b + real(0.5, 5) * n * (random_() % 2 ? 1.0 : -1.0) + real(-2, 2) * across(n));
    const double ra = scalar("_radiusA", real(0.1, 3)), rb = scalar("_radiusB", real(0.1, 3));
    import("EccentricConeCollection");
    const dvec3 x = across(n), y = glm::cross(n, x);
    for (int i = 0; i < 20; ++i) {
      const double t = real(0, 1), angle = real(0, 2 * kPi), r = rb + (ra - rb) * t;
      expect_on_surface(b + t * (a - b) + r * (std::cos(angle) * x + std::sin(angle) * y), 10);
    }
  });
}

TEST_F(GltfCollectionsTest, EllipsoidSegments) {
  repeat([&] {
    const dvec3 n = glm::normalize(vector("_normal", direction()));
    const dvec3 c = vector("_center", {real(-9, 9), real(-9, 9), real(-9, 9)});
    const double across_radius = scalar("_horizontalRadius", real(0.2, 3)),
                 along = scalar("_verticalRadius", real(0.2, 3));
    const int which = int(random_() % 3);
    const double height = scalar("_height", which == 0 ? along : which == 1 ? 2 * along : real(0.05, 1.95) * along);
    import("EllipsoidSegmentCollection");
    EXPECT_EQ(scene_.kind(core::ItemId{0}), which == 0   ? core::Kind::kEllipticalDish
                                            : which == 1 ? core::Kind::kSphere
                                                         : core::Kind::kSphericalDish);
    const dvec3 x = across(n), y = glm::cross(n, x);
    for (int i = 0; i < 20; ++i) {
      const double h = along - real(0, height), angle = real(0, 2 * kPi);
      const double r = across_radius * std::sqrt(std::max(0.0, 1 - h * h / (along * along)));
      expect_on_surface(c + h * n + r * (std::cos(angle) * x + std::sin(angle) * y), 10);
    }
  });
}

TEST_F(GltfCollectionsTest, GeneralCylinders) {
  repeat([&] {
    const dvec3 axis = direction();
    const dvec3 b = vector("_centerB", {real(-9, 9), real(-9, 9), real(-9, 9)});
    const dvec3 a = vector("_centerA", b + real(8, 10) * axis);
    const dvec3 x = glm::normalize(vector("_localXAxis", across(axis)));
    const dvec3 z = glm::normalize(a - b), y = glm::cross(z, x);
    const double radius = scalar("_radius", real(0.2, 1));
    const auto plane = [&](const std::string& name, double outward) {
      const dvec3 normal = glm::normalize(dvec3(real(-1, 1), real(-1, 1), outward));
      const core::vec3 n(random_() % 4 ? normal : dvec3(0, 0, outward));
      column(name, "VEC4", {n.x, n.y, n.z, 99.0f});
      return dvec3(n);
    };
    const dvec3 na = plane("_planeA", 1.0), nb = plane("_planeB", -1.0);
    const bool whole = random_() % 3;
    const double from = scalar("_angle", whole ? 0.0 : real(-3, 3)),
                 arc = scalar("_arcAngle", whole ? 2 * kPi : real(0.5, 6));
    import("GeneralCylinderCollection");
    const double length = glm::length(a - b);
    const double za = length - radius * std::tan(std::acos(glm::dot(na, dvec3(0, 0, 1)) / glm::length(na)));
    const double zb = radius * std::tan(std::acos(glm::dot(nb, dvec3(0, 0, -1)) / glm::length(nb)));
    for (int i = 0; i < 20; ++i) {
      const double angle = from + real(0, arc);
      const dvec3 local(radius * std::cos(angle), radius * std::sin(angle), 0.0);
      const double high = za - (local.x * na.x + local.y * na.y) / na.z,
                   low = zb - (local.x * nb.x + local.y * nb.y) / nb.z;
      const double h = i % 3 == 0 ? low : i % 3 == 1 ? high : real(low, high);
      expect_on_surface(b + local.x * x + local.y * y + h * z, 10, whole ? 1e-6 : kFacetError);
      // Nor does it go on beyond its ends.
      EXPECT_GT(distance_of(b + local.x * x + local.y * y + (i % 2 ? high + 1e-3 : low - 1e-3) * z), 1e-4);
    }
  });
}

TEST_F(GltfCollectionsTest, TorusSegments) {
  repeat([&] {
    const double s = real(0.5, 2);
    const core::Affine map = matrix({s, s, s});
    const double tube = scalar("_tubeRadius", real(0.1, 1)), radius = scalar("_radius", real(1, 5)),
                 arc = scalar("_arcAngle", random_() % 3 == 0 ? 2 * kPi : real(0.1, 6));
    import("TorusSegmentCollection");
    EXPECT_EQ(scene_.kind(core::ItemId{0}), core::Kind::kCircularTorus);
    for (int i = 0; i < 20; ++i) {
      const double theta = real(0, arc), phi = real(0, 2 * kPi), r = radius + tube * std::cos(phi);
      expect_on_surface(core::transform_point(map, {r * std::cos(theta), r * std::sin(theta), tube * std::sin(phi)}),
                        10);
    }
  });
}

TEST_F(GltfCollectionsTest, NutsAndTrapezia) {
  repeat([&] {
    const core::Affine map = matrix({2, 3, 4});
    import("NutCollection");
    for (int i = 0; i < 6; ++i) {
      const double angle = i * kPi / 3;
      expect_on_surface(core::transform_point(map, {0.5 * std::sin(angle), 0.5 * std::cos(angle), real(-0.5, 0.5)}), 4);
    }
    EXPECT_EQ(core::enclosure(scene_.mesh(scene_.mesh_of(core::ItemId{0}))), core::Enclosure::kInside);
    dvec3 v[4];
    for (int i = 0; i < 4; ++i)
      v[i] = vector("_vertex" + std::to_string(i + 1), {real(-9, 9), real(-9, 9), real(-9, 9)});
    import("TrapeziumCollection");
    for (const dvec3& corner : v) expect_on_surface(corner, 20);
    expect_on_surface((v[0] + v[3]) / 2.0, 20);
    EXPECT_EQ(scene_.mesh(scene_.mesh_of(core::ItemId{0})).indices.size(), 6u);
  });
}

TEST_F(GltfCollectionsTest, PartsGatherOverCollectionsWithZUp) {
  GltfBytes g = tests::small_gltf();
  const int trees = g.floats({7, 7, 7, 9, 9, 9}, "SCALAR");
  const int points = g.floats({0, 0, 0, 1, 0, 0, 0, 0, 4, 0, 0, 0, 2, 0, 0, 0, 0, 4}, "VEC3");
  const int colours = g.accessor<std::uint8_t>(
      {255, 0, 0, 255, 255, 0, 0, 255, 255, 0, 0, 255, 0, 0, 255, 255, 0, 0, 255, 255, 0, 0, 255, 255}, "VEC4", true);
  const int mesh = g.mesh({{"attributes", {{"POSITION", points}, {"_treeIndex", trees}, {"COLOR_0", colours}}}});
  g.root({{"name", "TriangleMesh"}, {"mesh", mesh}, {"translation", {0, 0, 1}}});
  const auto report = read_gltf(g.glb(), "plant.glb", scene_, scene_.root());
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_TRUE(scene_.commit());
  std::map<std::string, int> items;
  std::map<std::string, double> top;
  for (core::ItemId item{0}; to_index(item) < scene_.item_slots(); ++item) {
    const std::string path = scene_.path(scene_.node_of(item));
    ++items[path];
    const auto box = scene_.bounds_under(item, scene_.state(item).world_from_item);
    top[path] = std::max(top[path], box.max.z);
  }
  EXPECT_EQ(items["plant.glb/7"], 3);  // a box, a trapezium and a triangle
  EXPECT_EQ(items["plant.glb/8"], 2);
  EXPECT_EQ(items["plant.glb/9"], 1);
  EXPECT_NEAR(top["plant.glb/9"], 5.0, 1e-6);  // z is up
  EXPECT_NEAR(top["plant.glb/7"], 7.5, 1e-6);
}

TEST_F(GltfCollectionsTest, AlphaOfColoursIsIgnored) {
  GltfBytes g;
  const std::vector<std::uint8_t> reds = {255, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0,
                                          255, 0, 0, 9, 255, 0, 0, 9, 255, 0, 0, 9};
  const int trees = g.floats({7, 7, 7, 7, 7, 7}, "SCALAR"), colours = g.accessor(reds, "VEC4", true);
  const int points = g.floats({0, 0, 0, 1, 0, 0, 0, 0, 4, 0, 0, 0, 2, 0, 0, 0, 0, 4}, "VEC3");
  const int part = g.mesh({{"attributes", {{"POSITION", points}, {"_treeIndex", trees}, {"COLOR_0", colours}}}});
  g.root({{"name", "TriangleMesh"}, {"mesh", part}});
  const int copied = g.mesh({{"attributes", {{"POSITION", points}}}});
  const int tree = g.floats({8}, "SCALAR"), colour = g.accessor<std::uint8_t>({255, 0, 0, 0}, "VEC4", true);
  const int matrix = g.floats({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1}, "MAT4");
  const Json attributes = {{"_treeIndex", tree}, {"_color", colour}, {"_instanceMatrix", matrix}};
  g.root({{"name", "InstanceMesh"},
          {"mesh", copied},
          {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", attributes}}}}}});
  const auto report = read_gltf(g.glb(), "plant.glb", scene_, scene_.root());
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(scene_.item_count(), 2u);  // alpha parts no mesh, either
  ASSERT_EQ(scene_.material_slots(), 1u);
  for (core::ItemId item{0}; to_index(item) < 2; ++item) {
    const core::Material& material = scene_.material(scene_.item_material(item));
    EXPECT_EQ(material.name, "#ff0000");
    EXPECT_EQ(material.colour, core::vec3(1, 0, 0));
    EXPECT_EQ(material.alpha, 1.0f);
  }
}

TEST_F(GltfCollectionsTest, WhatHasNoShapeIsDroppedAndListed) {
  vector("_centerA", {1, 2, 3}), vector("_centerB", {1, 2, 3}), vector("_localXAxis", {1, 0, 0});
  scalar("_radiusA", 1), scalar("_radiusB", 1), scalar("_angle", 0), scalar("_arcAngle", 6.3);
  column("_treeIndex", "SCALAR", {1.0f});
  file_.root(
      {{"name", "ConeCollection"}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", attributes_}}}}}});
  const auto report = read_gltf(file_.glb(), "plant.glb", scene_, scene_.root());
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(scene_.item_count(), 0u);
  ASSERT_EQ(report->warnings.size(), 2u);
  // A column that is missing is damage.
  file_.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"].erase("_radiusA");
  EXPECT_FALSE(read_gltf(file_.glb(), "plant.glb", scene_, scene_.root()));
  EXPECT_TRUE(read_gltf(file_.glb(), "plant.glb", scene_, scene_.root(), {.lenient = true}));
}

TEST_F(GltfCollectionsTest, AxesAlongTheFramesOwn) {
  for (int axis = 0; axis < 3; ++axis) {
    dvec3 n(0.0);
    n[axis] = 1.0;
    const dvec3 x = across(n), y = glm::cross(n, x);
    vector("_normal", n), vector("_centerA", 3.0 * n), vector("_centerB", {0, 0, 0});
    scalar("_radiusA", 2), scalar("_radiusB", 1);
    import("EccentricConeCollection");
    expect_on_surface(3.0 * n + std::sqrt(2.0) * (x + y), 10);
    vector("_localXAxis", n), vector("_centerA", 3.0 * n), vector("_centerB", {0, 0, 0});  // says nothing
    scalar("_radiusA", 2), scalar("_radiusB", 1), scalar("_angle", 0), scalar("_arcAngle", 6.28318);
    import("ConeCollection");
    EXPECT_EQ(scene_.kind(core::ItemId{0}), core::Kind::kSnout);
    expect_on_surface(3.0 * n + std::sqrt(2.0) * (x + y), 10);
  }
}

TEST_F(GltfCollectionsTest, NearlyWholeTurnsAndFullRings) {
  vector("_centerA", {0, 0, 2}), vector("_centerB", {0, 0, 0}), vector("_localXAxis", {1, 0, 0});
  scalar("_radiusA", 1), scalar("_radiusB", 1), scalar("_angle", 0), scalar("_arcAngle", 6.2);
  import("ConeCollection");
  EXPECT_EQ(scene_.kind(core::ItemId{0}), core::Kind::kRectangularTorus);  // a slit stays open
  scalar("_thickness", 1.5), scalar("_angle", 0), scalar("_arcAngle", 2 * kPi);
  matrix({1, 1, 0});
  import("GeneralRingCollection");
  EXPECT_EQ(std::get<core::RectangularTorus>(scene_.primitive(core::ItemId{0})).inner_radius, 0.0f);
}

TEST_F(GltfCollectionsTest, SteepPlanesOfCylinders) {
  for (const double z : {0.3, 0.0, -0.3}) {
    vector("_centerA", {0, 0, 9}), vector("_centerB", {0, 0, 0}), vector("_localXAxis", {1, 0, 0});
    scalar("_radius", 1), scalar("_angle", 0), scalar("_arcAngle", 2 * kPi);
    column("_planeA", "VEC4", {1, 0, float(z), 0}), column("_planeB", "VEC4", {0, 0, -1, 0});
    if (z > 0.0) {
      import("GeneralCylinderCollection");
      expect_on_surface({1, 0, 9 - 2 / 0.3}, 10);
      continue;
    }
    file_.root({{"name", "GeneralCylinderCollection"},
                {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", attributes_}}}}}});
    column("_treeIndex", "SCALAR", {1.0f});
    file_.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = attributes_;
    scene_ = core::Scene();
    const auto report = read_gltf(file_.glb(), "plant.glb", scene_, scene_.root());
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(scene_.item_count(), 0u);  // the plane does not face its end
    EXPECT_EQ(report->warnings.size(), 2u);
    file_ = {};
  }
}

TEST_F(GltfCollectionsTest, TreeIndicesAndColoursOfAnyType) {
  const auto boxes = [&](const std::vector<float>& trees, int colours, GltfBytes& g) {
    std::vector<float> matrices;
    for (std::size_t i = 0; i < trees.size(); ++i)
      matrices.insert(matrices.end(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, float(i), 0, 0, 1});
    const Json attributes = {{"_treeIndex", g.floats(trees, "SCALAR")},
                             {"_color", colours},
                             {"_instanceMatrix", g.floats(matrices, "MAT4")}};
    g.root({{"name", "BoxCollection"}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", attributes}}}}}});
    scene_ = core::Scene();
    const auto report = read_gltf(g.glb(), "plant.glb", scene_, scene_.root());
    EXPECT_TRUE(report) << report.error().message;
  };
  GltfBytes plain, bytes, shorts;
  boxes({0, -1, 4294967295.0f}, plain.floats({1, 0, 0.2f, 0, 1, 0, 0.2f, 0, 1, 0, 0.2f, 0}, "VEC4"), plain);
  ASSERT_EQ(scene_.item_count(), 3u);
  EXPECT_EQ(scene_.path(scene_.node_of(core::ItemId{0})), "plant.glb/0");
  EXPECT_EQ(scene_.path(scene_.node_of(core::ItemId{1})), "plant.glb/BoxCollection");  // parts of no tree
  EXPECT_EQ(scene_.path(scene_.node_of(core::ItemId{2})), "plant.glb/BoxCollection");
  const core::vec3 colour(1.0f, 0.0f, 51 / 255.0f);
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).colour, colour);
  boxes({1}, bytes.accessor<std::uint8_t>({255, 0, 51, 0}, "VEC4"), bytes);
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).colour, colour);
  boxes({1}, shorts.accessor<std::uint16_t>({65535, 0, 13107, 0}, "VEC4"), shorts);
  EXPECT_EQ(scene_.material(scene_.item_material(core::ItemId{0})).colour, colour);
}

TEST_F(GltfCollectionsTest, FacesOfOnePartAndColourAreOneMesh) {
  GltfBytes g;
  const auto columns = [&](const dvec3& v) {
    std::vector<float> values;
    for (int i = 0; i < 4; ++i) values.insert(values.end(), {float(v.x), float(v.y), float(v.z)});
    return g.floats(values, "VEC3");
  };
  const int colours = g.accessor<std::uint8_t>({9, 9, 9, 0, 9, 9, 9, 0, 8, 8, 8, 0, 8, 8, 8, 0}, "VEC4", true);
  const Json attributes = {{"_treeIndex", g.floats({1, 1, 1, 2}, "SCALAR")},
                           {"_color", colours},
                           {"_vertex1", columns({0, 0, 0})},
                           {"_vertex2", columns({1, 0, 0})},
                           {"_vertex3", columns({0, 1, 0})},
                           {"_vertex4", columns({1, 1, 0})}};
  g.root(
      {{"name", "TrapeziumCollection"}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", attributes}}}}}});
  const auto report = read_gltf(g.glb(), "plant.glb", scene_, scene_.root(), {.copies = MeshCopies::kApart});
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(scene_.item_count(), 3u);
  const std::size_t corners[] = {12, 6, 6};
  for (core::ItemId i{0}; to_index(i) < 3; ++i)
    EXPECT_EQ(scene_.mesh(scene_.mesh_of(i)).indices.size(), corners[to_index(i)]);
}

}  // namespace
}  // namespace sightline::importers::gltf_collections_test
