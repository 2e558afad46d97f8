// Features and dimensions against points of the solids and against hand-made cases.
#include "sightline/analysis/measure/features.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "sightline/analysis/measure/distances.h"
#include "sightline/tests/analysis/measure/measure_samples.h"

namespace sightline::features_test {
namespace {

using core::Affine;
using core::dvec3;
using core::Kind;
using measure::Arc;
using measure::Face;
using measure::Feature;
using measure::FeatureKind;
using measure::Segment;
using tests::Random;
using tests::uniform;

constexpr std::uint64_t kSeed = 18;

std::vector<Feature> features_of(const core::Primitive& primitive, const Affine& a) {
  return *measure::features(primitive, a);
}

std::vector<measure::Dimension> list_dimensions(const core::Primitive& primitive, const Affine& a) {
  return *measure::dimensions(primitive, a);
}

std::map<std::string, int> words_of(const core::Primitive& primitive, const Affine& a) {
  std::map<std::string, int> words;
  for (const Feature& feature : features_of(primitive, a)) ++words[measure::describe(feature)];
  return words;
}

using Words = std::map<std::string, int>;

TEST(Features, WordsOfEachKind) {
  const Affine level;
  EXPECT_EQ(words_of(core::Box{1, 2, 3}, level),
            (Words{{"corner of a box", 8}, {"edge of a box", 12}, {"face of a box", 6}}));
  EXPECT_EQ(words_of(core::Pyramid{1, 2, 0, 0, 0, 0, 3}, level),
            (Words{{"corner of a pyramid", 5}, {"edge of a pyramid", 8}, {"face of a pyramid", 5}}));
  EXPECT_EQ(words_of(core::Cylinder{1, 2}, level), (Words{{"axis of a cylinder", 1},
                                                          {"edge of the lower end of a cylinder", 1},
                                                          {"centre of the lower end of a cylinder", 1},
                                                          {"face of the lower end of a cylinder", 1},
                                                          {"edge of the upper end of a cylinder", 1},
                                                          {"centre of the upper end of a cylinder", 1},
                                                          {"face of the upper end of a cylinder", 1}}));
  const Affine lying{{0, 1, 0, 0, 0, 1, 1, 0, 0}, {}};
  EXPECT_EQ(words_of(core::Cylinder{1, 2}, lying)["centre of an end of a cylinder"], 2);
  EXPECT_EQ(words_of(core::Snout{1, 0, 2, 0, 0, 0, 0, 0, 0}, level)["the tip of a snout"], 1);
  EXPECT_EQ(words_of(core::Sphere{1}, level), (Words{{"centre of a sphere", 1}}));
  EXPECT_EQ(words_of(core::Line{1, 2}, level), (Words{{"the end of a line", 2}, {"edge of a line", 1}}));
  const Words bend = words_of(core::CircularTorus{1, 0.2f, 1.5f}, level);
  EXPECT_EQ(bend.at("centre line of a circular torus"), 1);
  EXPECT_EQ(bend.at("centre of the bend of a circular torus"), 1);
  EXPECT_EQ(bend.at("centre of an end of a circular torus"), 2);
  const Words ring = words_of(core::CircularTorus{1, 0.2f, 6.3f}, level);
  EXPECT_EQ(ring.size(), 2u);
  EXPECT_EQ(words_of(core::EllipticalDish{1, 1}, level)["centre of the base of an elliptical dish"], 1);
  EXPECT_EQ(words_of(core::RectangularTorus{1, 2, 1, 1.5f}, level)["corner of a rectangular torus"], 8);
}

/// The end that lies lower is so called, however the placement turns it.
TEST(Features, LowerIsLower) {
  Random random(kSeed);
  for (int i = 0; i < 200; ++i) {
    const Affine a = tests::placement(random, 1.0, 1e6);
    const auto features = *measure::features(core::Snout{1, 2, 3, 0.5f, 0, 0.1f, 0, 0, 0.2f}, a);
    std::map<std::string, dvec3> centres;
    for (const Feature& f : features)
      if (f.kind == FeatureKind::kCentre) centres[measure::describe(f)] = std::get<dvec3>(f.geometry);
    ASSERT_EQ(centres.size(), 2u);
    EXPECT_LT(centres["centre of the lower end of a snout"].z, centres["centre of the upper end of a snout"].z);
  }
}

/// Distances of a point of a face from its plane, and of the face's normal from being outward.
TEST(Features, FacesAreOnTheSurfaceAndFaceOutwards) {
  Random random(kSeed);
  for (int i = 0; i < 4000; ++i) {
    const Kind kind = tests::random_of(tests::kSolidKinds, random);
    const core::Primitive primitive = tests::ordinary_primitive(kind, random);
    const Affine a = tests::placement(random, std::pow(10.0, uniform(random, -3.0, 3.0)), 1e6);
    const double size = tests::size_of(primitive, a);
    for (const Feature& f : features_of(primitive, a)) {
      if (f.kind != FeatureKind::kFace) continue;
      const Face& face = std::get<Face>(f.geometry);
      EXPECT_NEAR(glm::length(face.normal), 1.0, 1e-12);
      const double tolerance = 1e-9 * size + 1e-8;
      for (const dvec3& corner : face.corners) EXPECT_NEAR(glm::dot(face.normal, corner - face.centre), 0.0, tolerance);
      EXPECT_NEAR(glm::dot(face.normal, face.u), 0.0, tolerance);
      EXPECT_NEAR(glm::dot(face.normal, face.v), 0.0, tolerance);
      EXPECT_NEAR(glm::dot(face.u, face.v), 0.0, tolerance * size);
      if (kind != Kind::kCircularTorus && kind != Kind::kRectangularTorus) {
        // A convex solid lies behind its faces, and reaches them.
        EXPECT_NEAR(tests::placed_support(primitive, a, face.normal, face.centre), 0.0, tolerance);
      } else {
        // A step outwards leaves the solid, one inwards does not.
        dvec3 inner = face.centre;
        if (face.inner > 0.0) {
          const double t = 0.5 * (face.from + face.to), s = 0.5 * (face.inner + 1.0);
          inner += s * (std::cos(t) * face.u + std::sin(t) * face.v);
        }
        const auto item = *measure::Item::create(primitive, a);
        const double step = 1e-4 * size;
        EXPECT_NEAR(measure::distance(inner + step * face.normal, item).distance, step, 1e-2 * step + 1e-8);
        EXPECT_TRUE(measure::distance(inner - step * face.normal, item).touching);
      }
    }
    if (HasFailure()) FAIL() << "seed " << kSeed << ": " << tests::text_of(primitive, a);
  }
}

/// Slanted ends: their rims lie on the leaning cone and on the end's plane.
TEST(Features, RimsOfSlantedSnoutsAreOnConeAndPlane) {
  Random random(kSeed);
  int tried = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto length = [&] { return float(uniform(random, 0.2, 2.0)); };
    const auto slant = [&] { return float(uniform(random, -0.6, 0.6)); };
    const core::Snout s{length(), length(), 2 * length(), slant(), slant(), slant(), slant(), slant(), slant()};
    int rims = 0;
    for (const Feature& f : features_of(s, {})) {
      if (f.kind != FeatureKind::kEdge) continue;
      const Arc& rim = std::get<Arc>(f.geometry);
      const bool top = rims == 1;
      for (int k = 0; k < 32; ++k) {
        const double t = 0.2 * k, h = s.height;
        const dvec3 p = rim.centre + std::cos(t) * rim.u + std::sin(t) * rim.v;
        const double radius = s.bottom_radius + (double(s.top_radius) - s.bottom_radius) * (p.z / h + 0.5);
        EXPECT_NEAR(std::hypot(p.x - s.offset_x * p.z / h, p.y - s.offset_y * p.z / h), radius, 1e-9);
        const double side = top ? 0.5 : -0.5, tx = std::tan(double(top ? s.top_shear_x : s.bottom_shear_x)),
                     ty = std::tan(double(top ? s.top_shear_y : s.bottom_shear_y));
        EXPECT_NEAR(p.z, side * h + tx * (p.x - side * s.offset_x) + ty * (p.y - side * s.offset_y), 1e-9);
      }
      ++rims;
    }
    EXPECT_TRUE(rims == 0 || rims == 2);
    tried += rims;
    if (HasFailure()) FAIL() << "seed " << kSeed << ": " << tests::text_of(s, {});
  }
  EXPECT_GT(tried, 2000);
}

TEST(Features, PrincipalAxesKeepTheEllipse) {
  Random random(kSeed);
  for (int i = 0; i < 2000; ++i) {
    const Arc any{
        {1, 2, 3}, uniform(random, 0, 2) * tests::random_direction(random), tests::random_direction(random), 0.3, 2.0};
    const Arc axes = measure::principal_axes(any);
    EXPECT_NEAR(glm::dot(axes.u, axes.v), 0.0, 1e-14);
    EXPECT_GE(glm::length(axes.u), glm::length(axes.v));
    EXPECT_NEAR(axes.to - axes.from, 1.7, 1e-14);
    for (const double share : {0.0, 0.4, 1.0}) {
      const double s = any.from + 1.7 * share, t = axes.from + 1.7 * share;
      EXPECT_LE(glm::length(std::cos(s) * any.u + std::sin(s) * any.v - std::cos(t) * axes.u - std::sin(t) * axes.v),
                1e-14);
    }
  }
}

std::map<std::string, double> dimensions_of(const core::Primitive& primitive, const Affine& a) {
  std::map<std::string, double> found;
  for (const measure::Dimension& d : list_dimensions(primitive, a)) found[std::string(d.name)] = d.value;
  return found;
}

TEST(Features, DimensionsOfEachKind) {
  Random random(kSeed);
  const Affine half{0.5 * tests::random_rotation(random), {1e6, 0, 0}};
  using Values = std::map<std::string, double>;
  const auto expect = [&](const core::Primitive& primitive, const Affine& a, const Values& expected) {
    const Values found = dimensions_of(primitive, a);
    ASSERT_EQ(found.size(), expected.size()) << core::name_of(core::kind_of(primitive));
    for (const auto& [name, value] : expected) {
      ASSERT_TRUE(found.contains(name)) << name;
      EXPECT_NEAR(found.at(name), value, 1e-12) << name;
    }
  };
  expect(core::Box{1, 2, 3}, half, {{"size x", 0.5}, {"size y", 1}, {"size z", 1.5}});
  expect(core::Pyramid{1, 2, 3, 4, 1, 1, 5}, half,
         {{"bottom x", 0.5}, {"bottom y", 1}, {"top x", 1.5}, {"top y", 2}, {"height", 2.5}});
  expect(core::Cylinder{1, 4}, half, {{"diameter", 1}, {"length", 2}});
  expect(core::Snout{1, 2, 4, 3, 0, 0.1f, 0, 0, 0}, half,
         {{"bottom diameter", 1}, {"top diameter", 2}, {"length", 2.5}});
  expect(core::CircularTorus{2, 0.5f, 1.5f}, half, {{"tube diameter", 0.5}, {"bend radius", 1}, {"sweep", 1.5}});
  expect(core::RectangularTorus{2, 3, 1, 1.5f}, half,
         {{"inner radius", 1}, {"outer radius", 1.5}, {"height", 0.5}, {"sweep", 1.5}});
  expect(core::EllipticalDish{2, 1}, half, {{"base diameter", 2}, {"height", 0.5}});
  expect(core::SphericalDish{2, 1}, half, {{"base diameter", 2}, {"height", 0.5}});
  expect(core::Sphere{2}, half, {{"diameter", 1}});
  expect(core::Line{-1, 3}, half, {{"length", 2}});
  // Unequal scales, and a shear along the axis, which leaves the section perpendicular to it as it is.
  expect(core::Cylinder{1, 4}, {{3, 0, 0, 0, 2, 0, 0, 0, 1}, {}},
         {{"largest diameter", 6}, {"smallest diameter", 4}, {"length", 4}});
  expect(core::Cylinder{1, 4}, {{1, 0, 5, 0, 1, 0, 0, 0, 1}, {}}, {{"diameter", 2}, {"length", 4}});
  expect(core::Sphere{2}, {{3, 0, 0, 0, 2, 0, 0, 0, 1}, {}}, {{"largest diameter", 6}, {"smallest diameter", 2}});
}

/// An ellipsoid's largest and smallest diameters are the extremes of its width.
TEST(Features, DiametersOfEllipsoids) {
  Random random(kSeed);
  for (int i = 0; i < 50; ++i) {
    const Affine a = tests::random_affine(random, 1.0, 0.0);
    const auto found = dimensions_of(core::Sphere{1}, a);
    double widest = 0.0, narrowest = 1e300;
    for (int k = 0; k < 20000; ++k) {
      const dvec3 u = tests::random_direction(random);
      const double width = 2.0 * core::support(core::Sphere{1}, u * a.linear);
      widest = std::max(widest, width), narrowest = std::min(narrowest, width);
    }
    EXPECT_GE(found.at("largest diameter"), widest - 1e-12) << kSeed << ": " << i;
    EXPECT_NEAR(found.at("largest diameter"), widest, 2e-3 * widest) << kSeed << ": " << i;
    EXPECT_LE(found.at("smallest diameter"), narrowest + 1e-12) << kSeed << ": " << i;
    EXPECT_NEAR(found.at("smallest diameter"), narrowest, 1e-2 * widest) << kSeed << ": " << i;
  }
}

TEST(Features, DegenerateAndBadInput) {
  Random random(kSeed);
  for (int i = 0; i < 3000; ++i) {
    core::Primitive primitive = tests::ordinary_primitive(tests::random_of(tests::kSolidKinds, random), random);
    std::vector<float> values(core::parameters(primitive).begin(), core::parameters(primitive).end());
    for (float& value : values)
      if (random() % 2 == 0) value = 0.0f;
    primitive = core::make_primitive(core::kind_of(primitive), values);
    Affine a = tests::placement(random, 1.0, 2.0);
    if (i % 3 == 0) a.linear[2] = dvec3(0.0);
    for (const Feature& f : features_of(primitive, a)) {
      EXPECT_TRUE(std::isfinite(measure::distance(f.geometry, dvec3(0.0)).distance)) << tests::text_of(primitive, a);
      EXPECT_FALSE(measure::describe(f).empty());
    }
    for (const measure::Dimension& d : list_dimensions(primitive, a)) EXPECT_TRUE(std::isfinite(d.value)) << d.name;
  }
  EXPECT_FALSE(measure::features(core::Sphere{NAN}, {}));
  EXPECT_FALSE(measure::dimensions(core::Sphere{1}, core::translation({NAN, 0, 0})));
}

}  // namespace
}  // namespace sightline::features_test
