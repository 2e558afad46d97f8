// Snapping: what is aimed at is found, exactly, and nothing that is hidden or cut away.
#include "sightline/analysis/measure/snap.h"

#include <array>
#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>

#include "sightline/analysis/measure/distances.h"
#include "sightline/core/mesh_extras.h"
#include "sightline/tests/analysis/measure/measure_samples.h"

namespace sightline::snap_test {
namespace {

using core::Affine;
using core::dvec3;
using core::Plane;
using core::SectionMode;
using measure::Aim;
using measure::FeatureKind;
using measure::Item;
using measure::Snap;
using tests::Random;
using tests::uniform;

constexpr std::uint64_t kSeed = 18;
constexpr double kFar = 1e6;

Item item_of(const core::Primitive& primitive, const Affine& a = {}) {
  return *Item::create(primitive, a);
}

/// An eye that looks at a point, with a cone of `reach` metres there.
Aim look(const dvec3& eye, const dvec3& point, double reach) {
  const double depth = glm::length(point - eye);
  return {point, 0.0, measure::AimRay{eye, (point - eye) / depth, reach / depth}};
}

std::string words_at(const Item& item, const Aim& aim, std::span<const Plane> sections = {}) {
  const auto found = measure::snap(item, aim, sections);
  return found ? found->words : "nothing";
}

TEST(Snap, EachKindInItsOrder) {
  const Item pipe = item_of(core::Cylinder{0.1f, 4.0f});
  const dvec3 above(0.5, 0.3, 6);
  EXPECT_EQ(words_at(pipe, look(above, {0.01, 0, 2}, 0.02)), "centre of the upper end of a cylinder");
  EXPECT_EQ(words_at(pipe, look(above, {0.05, 0, 2}, 0.02)), "face of the upper end of a cylinder");
  EXPECT_EQ(words_at(pipe, look(above, {0.099, 0, 2}, 0.02)), "edge of the upper end of a cylinder");
  const dvec3 side(6, 0, 0);
  EXPECT_EQ(words_at(pipe, look(side, {0.1, 0.0, 0.5}, 0.02)), "axis of a cylinder");
  EXPECT_EQ(words_at(pipe, look(side, {0.08, 0.06, 0.5}, 0.02)), "surface of a cylinder");
  EXPECT_EQ(words_at(pipe, look(side, {0.1, 0.0, 1.99}, 0.02)), "edge of the upper end of a cylinder");
  const auto axis = measure::snap(pipe, look(side, {0.1, 0.0, 0.5}, 0.02));
  EXPECT_LE(glm::length(axis->point - dvec3(0, 0, 0.5 * 6 / 5.9)), 1e-9);

  const Item bend = item_of(core::CircularTorus{1.0f, 0.1f, 1.5f});
  EXPECT_EQ(words_at(bend, look({1, 1, 5}, {std::cos(0.7), std::sin(0.7), 0.1}, 0.05)),
            "centre line of a circular torus");
  const Item box = item_of(core::Box{1, 1, 1});
  EXPECT_EQ(words_at(box, look({2, 3, 4}, {0.49, 0.48, 0.5}, 0.05)), "corner of a box");
  EXPECT_EQ(words_at(box, look({2, 3, 4}, {0.1, 0.48, 0.5}, 0.05)), "edge of a box");
  EXPECT_EQ(words_at(box, look({2, 3, 4}, {0.1, 0.2, 0.5}, 0.05)), "face of a box");
  EXPECT_EQ(words_at(box, Aim{{0.49, 0.48, 0.5}, 0.05, {}}), "corner of a box");
  EXPECT_EQ(words_at(box, Aim{{0.3, 0.3, 2.0}, 0.05, {}}), "nothing");
  EXPECT_EQ(words_at(item_of(core::Sphere{1}), look({0, 0, 5}, {0, 0, 0.5}, 0.01)), "centre of a sphere");
}

/// Each point of each kind's surface is snapped to, if only as a point of the surface, and stays where it is.
TEST(Snap, EveryPointOfASurface) {
  Random random(kSeed);
  std::array<int, core::kKindCount> bare{};
  for (int i = 0; i < 4000; ++i) {
    const core::Kind kind = tests::random_of(tests::kSolidKinds, random);
    const core::Primitive primitive = tests::ordinary_primitive(kind, random);
    const Affine a = tests::placement(random, 1.0, i % 2 == 0 ? 1e4 : 0.0);
    const Item item = item_of(primitive, a);
    const double size = tests::size_of(primitive, a), reach = 1e-4 * size;
    const dvec3 eye = a.origin + 5.0 * size * tests::random_direction(random);
    const dvec3 on = measure::distance(eye + size * tests::random_direction(random), item).to;
    const dvec3 picked = on + 1e-7 * size * tests::random_direction(random);  // as picks round
    for (const Aim& aim : {look(eye, picked, reach), Aim{picked, reach, {}}}) {
      const auto found = measure::snap(item, aim);
      ASSERT_TRUE(found) << "seed " << kSeed << ": " << i << ' ' << tests::text_of(primitive, a);
      if (found->feature.kind != FeatureKind::kSurface) continue;
      ++bare[std::size_t(kind)];
      EXPECT_LE(glm::length(found->point - picked), reach) << "seed " << kSeed << ": " << i;
      EXPECT_LE(measure::distance(found->point, item).distance, 1e-6 * size) << "seed " << kSeed << ": " << i;
    }
  }
  for (const core::Kind kind : {core::Kind::kSphere, core::Kind::kCylinder, core::Kind::kCircularTorus,
                                core::Kind::kEllipticalDish, core::Kind::kSphericalDish, core::Kind::kSnout})
    EXPECT_GT(bare[std::size_t(kind)], 40) << core::name_of(kind);
}

/// The cap that a section plane leaves has points, too, and what is picked beside the plane lies in it within the rounding
/// of the item's coordinates (core/internal/section_rounding.h).
TEST(Snap, CapsOfSections) {
  const Item ball = item_of(core::Sphere{2}, core::translation({kFar, 0, 0}));
  const Plane keep_lower{{0, 0, -1}, 0.3};
  for (const double off : {-1e-6, 0.0, 1e-6}) {
    const auto found =
        measure::snap(ball, look({kFar, 0, 5}, {kFar + 0.2, 0.1, 0.3 + off}, 0.01), std::span(&keep_lower, 1));
    ASSERT_TRUE(found) << off;
    EXPECT_EQ(found->words, "surface of a sphere");
    EXPECT_NEAR(found->point.z, 0.3, 1e-5);
  }
  EXPECT_FALSE(measure::snap(ball, look({kFar + 0.3, 0.4, 5}, {kFar + 0.3, 0.4, std::sqrt(0.75)}, 0.01),
                             std::span(&keep_lower, 1)));
}

TEST(Snap, OrthographicRays) {
  const Item box = item_of(core::Box{1, 1, 1});
  const measure::AimRay ray{{0.49, 0.48, 10}, {0, 0, -1}, 0.0};
  const auto found = measure::snap(box, Aim{{0.49, 0.48, 0.5}, 0.05, ray});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->words, "corner of a box");
  EXPECT_EQ(found->point, dvec3(0.5, 0.5, 0.5));  // not the corner below it, which the cylinder of the aim holds, too
}

/// The far corners of a long beam appear near the middle of its end, and are hidden by it.
TEST(Snap, HiddenCornersDoNotCount) {
  const Item beam = item_of(core::Box{0.2f, 0.2f, 200.0f});
  const dvec3 eye(0, 0, 101);
  EXPECT_EQ(words_at(beam, look(eye, {0.001, 0, 100}, 0.02)), "face of a box");
  EXPECT_EQ(words_at(beam, look(eye, {0.099, 0.099, 100}, 0.02)), "corner of a box");
  // What is cut off hides nothing: the edges are seen where they now begin.
  const Plane keep_lower{{0, 0, -1}, -99.9};
  const auto seen = measure::snap(beam, look(eye, {0.001, 0, -99.9}, 0.3), std::span(&keep_lower, 1));
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->words, "edge of a box");
  EXPECT_NEAR(seen->point.z, -99.9, 1e-8);
}

/// Corners and edges of boxes of any placement, far from the origin.
TEST(Snap, CornersAndEdgesAreExact) {
  Random random(kSeed);
  for (int i = 0; i < 3000; ++i) {
    const core::Box box{float(uniform(random, 0.5, 2)), float(uniform(random, 0.5, 2)), float(uniform(random, 0.5, 2))};
    Affine a = tests::placement(random, 1.0, 0.0);
    a.origin = kFar * tests::random_direction(random);
    const Item item = item_of(box, a);
    const dvec3 half = 0.5 * dvec3(box.size_x, box.size_y, box.size_z);
    dvec3 corner;
    for (int k = 0; k < 3; ++k) corner[k] = random() % 2 == 0 ? half[k] : -half[k];
    dvec3 local = corner;
    const bool on_edge = i % 2 == 0;
    if (on_edge) local.x = uniform(random, -0.6, 0.6) * half.x;
    const dvec3 at = core::transform_point(a, local);
    const auto found = measure::snap(item, Aim{at + 1e-3 * tests::random_direction(random), 2e-3, {}});
    ASSERT_TRUE(found) << "seed " << kSeed << ": " << i;
    EXPECT_EQ(found->words, on_edge ? "edge of a box" : "corner of a box") << "seed " << kSeed << ": " << i;
    if (on_edge) {
      const dvec3 u = glm::normalize(a.linear[0]), off = found->point - at;
      EXPECT_LE(glm::length(off - u * glm::dot(off, u)), 1e-8) << "seed " << kSeed << ": " << i;
    } else {
      EXPECT_LE(glm::length(found->point - at), 1e-8) << "seed " << kSeed << ": " << i;
    }
  }
}

bool is_kept(const dvec3& p, std::span<const Plane> planes, SectionMode mode, double tolerance) {
  bool all = true, any = false;
  for (const Plane& plane : planes) {
    const bool inside = core::evaluate(plane, p) >= -tolerance;
    all = all && inside, any = any || inside;
  }
  return mode == SectionMode::kIntersection ? all : any;
}

/// The nearest kept one of many points of a curve, from an aim.
double nearest_sample(const measure::Feature& feature, const dvec3& aim, std::span<const Plane> planes,
                      SectionMode mode) {
  constexpr int kSamples = 20000;
  double least = 1e300;
  for (int i = 0; i <= kSamples; ++i) {
    const double t = double(i) / kSamples;
    dvec3 p;
    if (const auto* s = std::get_if<measure::Segment>(&feature.geometry)) {
      p = s->from + t * (s->to - s->from);
    } else {
      const auto& arc = std::get<measure::Arc>(feature.geometry);
      const double angle = arc.from + t * (arc.to - arc.from);
      p = arc.centre + std::cos(angle) * arc.u + std::sin(angle) * arc.v;
    }
    if (is_kept(p, planes, mode, 0.0)) least = std::min(least, glm::length(p - aim));
  }
  return least;
}

TEST(Snap, CutCurvesEndAtTheSection) {
  Random random(kSeed);
  int snapped = 0, shortened = 0;
  for (int i = 0; i < 150; ++i) {
    const core::Kind kinds[] = {core::Kind::kCylinder, core::Kind::kCircularTorus, core::Kind::kSnout,
                                core::Kind::kBox};
    const core::Primitive primitive = tests::ordinary_primitive(kinds[i % 4], random);
    const Affine a = tests::placement(random, 1.0, i % 2 == 0 ? 1e5 : 1.0);
    const Item item = item_of(primitive, a);
    const SectionMode mode = random() % 2 == 0 ? SectionMode::kIntersection : SectionMode::kUnion;
    std::vector<Plane> planes(1 + random() % 3);
    for (Plane& plane : planes) {
      plane.normal = uniform(random, 0.1, 3.0) * tests::random_direction(random);
      plane.offset = -glm::dot(plane.normal, a.origin + 0.5 * tests::random_direction(random));
    }
    const dvec3 at = a.origin + uniform(random, 0.0, 1.0) * tests::random_direction(random);
    const auto found = measure::snap(item, Aim{at, 3.0, {}}, planes, mode);
    if (!found) continue;
    EXPECT_TRUE(is_kept(found->point, planes, mode, 2e-5)) << "seed " << kSeed << ": " << i;
    if (found->feature.kind != FeatureKind::kEdge && found->feature.kind != FeatureKind::kAxis) continue;
    // The nearest of all features of that kind.
    double least = 1e300, uncut = 1e300;
    for (const measure::Feature& feature : item.features()) {
      if (feature.kind != found->feature.kind) continue;
      least = std::min(least, nearest_sample(feature, at, planes, mode));
      uncut = std::min(uncut, nearest_sample(feature, at, planes, SectionMode::kUnion));
      uncut = std::min(uncut, nearest_sample(feature, at, {}, SectionMode::kIntersection));
    }
    const double distance = glm::length(found->point - at);
    EXPECT_LE(distance, least + 1e-6 * 3.0) << "seed " << kSeed << ": " << i << ' ' << found->words;
    EXPECT_GE(distance, least - 2e-3) << "seed " << kSeed << ": " << i << ' ' << found->words;
    ++snapped;
    if (least > uncut + 1e-2) ++shortened;
  }
  EXPECT_GT(snapped, 60);
  EXPECT_GT(shortened, 20);
}

TEST(Snap, WhatIsCutAwayIsNotFound) {
  const Item pipe = item_of(core::Cylinder{0.1f, 4.0f}, core::translation({kFar, 0, 0}));
  const Plane keep_lower{{0, 0, -2}, 0.0};
  const std::span<const Plane> cut(&keep_lower, 1);
  EXPECT_EQ(words_at(pipe, Aim{{kFar, 0, 2}, 0.05, {}}), "centre of the upper end of a cylinder");
  EXPECT_EQ(words_at(pipe, Aim{{kFar, 0, 2}, 0.05, {}}, cut), "nothing");
  EXPECT_EQ(words_at(pipe, Aim{{kFar, 0, -2}, 0.05, {}}, cut), "centre of the lower end of a cylinder");
  // On the cap of the section the axis is found, at its new end.
  const auto axis = measure::snap(pipe, look({kFar - 0.3, 0, 5}, {kFar + 0.01, 0, 0}, 0.03), cut);
  ASSERT_TRUE(axis);
  EXPECT_EQ(axis->words, "axis of a cylinder");
  EXPECT_LE(glm::length(axis->point - dvec3(kFar, 0, 0)), 1e-8);
  const Plane none{{0, 0, 0}, -1.0};
  EXPECT_EQ(words_at(pipe, Aim{{kFar, 0, 2}, 0.05, {}}, std::span(&none, 1)), "centre of the upper end of a cylinder");
}

/// A cube of two triangles a side, its corners not shared.
core::Mesh cube() {
  core::Mesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      core::vec3 u(0.0f), v(0.0f), n(0.0f);
      n[axis] = side, u[(axis + 1) % 3] = 1.0f, v[(axis + 2) % 3] = side;
      const std::uint32_t first = std::uint32_t(mesh.positions.size());
      for (const core::vec3& p : {n - u - v, n + u - v, n + u + v, n - u + v}) mesh.positions.push_back(p);
      for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + i);
    }
  return mesh;
}

TEST(Snap, MeshesHaveSharpEdgesOnly) {
  const Item item = *Item::create(cube(), core::translation({kFar, 0, 0}));
  const auto at = [&](double x, double y, double z) { return Aim{{kFar + x, y, z}, 0.05, {}}; };
  EXPECT_EQ(words_at(item, at(0.98, 0.99, 1)), "corner of a mesh");
  EXPECT_EQ(words_at(item, at(0.3, 0.98, 1)), "edge of a mesh");
  EXPECT_EQ(words_at(item, at(0.0, 0.0, 1)), "face of a mesh");  // on the diagonal between two triangles
  EXPECT_EQ(words_at(item, at(0.5, 0.2, 1.2)), "nothing");
  const auto corner = measure::snap(item, look({kFar + 3, 4, 5}, {kFar + 0.98, 0.99, 1}, 0.05));
  ASSERT_TRUE(corner);
  EXPECT_LE(glm::length(corner->point - dvec3(kFar + 1, 1, 1)), 1e-9);
  EXPECT_FALSE(measure::snap(*Item::create(core::Mesh{}, {}), at(0, 0, 0)));
}

/// A wall of 32 facets about the z axis, from z = 0 to 1, that stands for a cylinder or a cone, whose radius at
/// the top is given; and a plane triangle beside it.
core::Mesh faceted(double top_radius) {
  core::Mesh mesh;
  for (int i = 0; i < 64; ++i) {
    const double angle = core::kFullTurn * (i / 2) / 32, r = i % 2 == 0 ? 1.0 : top_radius;
    mesh.positions.emplace_back(r * std::cos(angle), r * std::sin(angle), i % 2);
  }
  for (std::uint32_t i = 0; i < 32; ++i) {
    const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % 32);
    for (const std::uint32_t index : {a, b, b + 1, a, b + 1, a + 1}) mesh.indices.push_back(index);
  }
  for (const core::vec3& p : {core::vec3(2, 0, 0), core::vec3(4, 0, 0), core::vec3(2, 2, 0)}) {
    mesh.indices.push_back(std::uint32_t(mesh.positions.size()));
    mesh.positions.push_back(p);
  }
  using Surface = core::MeshSurface;
  Surface wall, plane;
  wall.kind = top_radius == 1.0 ? Surface::Kind::kCylinder : Surface::Kind::kCone;
  wall.radius = 1.0, wall.slope = top_radius - 1.0, wall.end_triangle = 64, wall.gap = 1e-6;
  plane.kind = Surface::Kind::kPlane, plane.end_triangle = 65, plane.gap = 1e-6;
  mesh.extras = core::MeshExtrasSlot({nullptr, std::make_shared<const std::vector<Surface>>(std::vector{wall, plane})});
  return mesh;
}

std::string dimension_words(const std::optional<Snap>& found) {
  std::string words = found ? "" : "nothing";
  for (const measure::Dimension& d : found ? found->dimensions : std::vector<measure::Dimension>()) {
    char text[80];
    std::snprintf(text, sizeof text, "%s%s %.5g", words.empty() ? "" : ", ", d.name.data(), d.value);
    words += text;
  }
  return words;
}

/// Between the facets the point is the cylinder's, and not the triangle's.
TEST(Snap, FacesOfMeshesAreTheSurfacesThatTheirFileStates) {
  const double near = std::cos(core::kFullTurn / 64);  // of the middle of a facet
  const dvec3 middle = near * dvec3(std::cos(core::kFullTurn / 64), std::sin(core::kFullTurn / 64), 0);
  for (const bool mirrored : {false, true}) {
    Affine place = core::translation({kFar, 0, 0});
    place.linear = 0.5 * place.linear;
    if (mirrored) place.linear[1] = -place.linear[1];
    const auto at = [&](const dvec3& p) { return core::transform_point(place, p); };
    const Item item = *Item::create(faceted(1.0), place);
    const auto wall = measure::snap(item, Aim{at(middle + dvec3(0, 0, 0.4)), 0.05, {}});
    ASSERT_TRUE(wall);
    EXPECT_EQ(wall->words, "surface of a cylindrical face of a mesh");
    EXPECT_EQ(dimension_words(wall), "diameter 1, radius 0.5, length 0.5");
    EXPECT_NEAR(glm::length(wall->point - at({0, 0, 0.4})), 0.5, 1e-8);
    ASSERT_TRUE(wall->axis);
    EXPECT_NEAR(glm::length(wall->axis->from - at({0, 0, 0})), 0.0, 1e-8);
    EXPECT_NEAR(glm::length(wall->axis->to - at({0, 0, 1})), 0.0, 1e-8);
    const auto axis = measure::snap(item, look(at({9, 0, 0.5}), at({near, 0, 0.5}), 0.01));
    EXPECT_EQ(axis ? axis->words : "nothing", "axis of a cylindrical face of a mesh");
    const auto plane = measure::snap(item, Aim{at({2.5, 0.5, 0}), 0.05, {}});
    EXPECT_EQ(plane ? plane->words : "nothing", "face of a mesh");
    EXPECT_EQ(dimension_words(plane), "");
  }
}

TEST(Snap, ConesHaveTheirAngle) {
  const auto found = measure::snap(*Item::create(faceted(0.5), {}), Aim{{0.7, 0.0, 0.6}, 0.02, {}});
  EXPECT_EQ(found ? found->words : "nothing", "surface of a conical face of a mesh");
  EXPECT_EQ(dimension_words(found), "half angle 0.46365, largest diameter 2, smallest diameter 1, length 1");
}

/// A copy keeps the surfaces as far as its triangles lie on them; an ellipse has no diameter.
TEST(Snap, SurfacesThatAreNoLongerTrueAreNotUsed) {
  const Aim aim{{0.0, 1.0, 0.4}, 0.05, {}};
  const core::Mesh copy = faceted(1.0);
  EXPECT_EQ(dimension_words(measure::snap(*Item::create(core::Mesh(copy), {}), aim)), "diameter 2, radius 1, length 1");
  core::Mesh moved = copy;
  for (core::vec3& p : moved.positions) p.x += 0.01f;
  EXPECT_EQ(dimension_words(measure::snap(*Item::create(moved, {}), aim)), "");
  Affine stretched;
  stretched.linear[2] = {0, 0, 3};
  EXPECT_EQ(dimension_words(measure::snap(*Item::create(copy, stretched), aim)), "");
}

/// A vertex within a straight edge is no corner.
TEST(Snap, VerticesWithinAnEdgeAreNoCorners) {
  core::Mesh sheet;
  sheet.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}};
  sheet.indices = {0, 1, 3, 1, 2, 3};
  const Item item = *Item::create(sheet, {});
  EXPECT_EQ(words_at(item, Aim{{1, 0, 0}, 0.05, {}}), "edge of a mesh");
  EXPECT_EQ(words_at(item, Aim{{2, 0, 0}, 0.05, {}}), "corner of a mesh");
}

}  // namespace
}  // namespace sightline::snap_test
