#include "sightline/gpuprims/internal/tessellation.h"

#include <array>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "intersection_twin.h"
#include "mesh_checks.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims::tessellation_test {
namespace {

using core::Kind;
using core::Primitive;
using twin::Random;
constexpr double kPi = std::numbers::pi;
constexpr Tessellation kFinest{.fixed_segments = 256};

bool is_sheared(const core::Snout& s) {
  return s.bottom_shear_x != 0 || s.bottom_shear_y != 0 || s.top_shear_x != 0 || s.top_shear_y != 0;
}

/// Whether both end planes cut the cone in closed contours, so that tessellation and intersection mean the same solid.
bool has_closed_ends(const core::Snout& s) {
  const double widening = (double(s.top_radius) - s.bottom_radius) / s.height;
  const auto closed = [&](double shear_x, double shear_y, double radius, const core::EndRange& range) {
    const core::dvec2 m(std::tan(shear_x), std::tan(shear_y));
    const double upright = 1.0 - (m.x * s.offset_x + m.y * s.offset_y) / s.height, steep = glm::length(m);
    if (upright <= std::fabs(widening) * steep) return false;
    const double up = radius * steep / (upright - widening * steep),
                 down = radius * steep / (upright + widening * steep);
    return range.max >= up * (1.0 - 1e-9) && range.min <= -down * (1.0 - 1e-9);
  };
  return closed(s.bottom_shear_x, s.bottom_shear_y, s.bottom_radius, core::bottom_end_range(s)) &&
         closed(s.top_shear_x, s.top_shear_y, s.top_radius, core::top_end_range(s));
}

/// Positive lengths over six orders of magnitude, aspects over four, with special values (0, equal, full turns) mixed
/// in.
Primitive random_primitive(Random& random, Kind kind) {
  const double scale = random.log_uniform(-3, 3);
  const auto length = [&] { return float(scale * random.log_uniform(-2, 2)); };
  const auto angle = [&] {
    const float special[] = {float(2.0 * kPi), float(0.5 * kPi), float(kPi), 0.01f};
    return random.below(2) ? special[random.below(4)] : float(random.uniform(0.05, 2.0 * kPi));
  };
  const auto maybe_zero = [&](float v) { return random.below(6) ? v : 0.0f; };
  switch (kind) {
    case Kind::kPyramid: {
      const float h = length();
      return core::Pyramid{maybe_zero(length()),
                           maybe_zero(length()),
                           maybe_zero(length()),
                           maybe_zero(length()),
                           maybe_zero(length()),
                           -length(),
                           h};
    }
    case Kind::kBox:
      return core::Box{length(), length(), length()};
    case Kind::kRectangularTorus: {
      const float a = length(), b = length();
      return core::RectangularTorus{maybe_zero(std::min(a, b)), std::max(a, b), length(), angle()};
    }
    case Kind::kCircularTorus: {
      const float r = length();
      const float major = random.below(4) ? r * float(random.log_uniform(0, 2)) : r * float(random.below(3)) * 0.5f;
      return core::CircularTorus{major, r, angle()};
    }
    case Kind::kEllipticalDish:
      return core::EllipticalDish{length(), length()};
    case Kind::kSphericalDish:
      return core::SphericalDish{maybe_zero(length()), length()};
    case Kind::kSnout: {
      core::Snout s{};
      s.bottom_radius = maybe_zero(float(scale * random.log_uniform(-1, 1)));
      s.top_radius = s.bottom_radius == 0.0f ? float(scale) : maybe_zero(float(scale * random.log_uniform(-1, 1)));
      s.height = float(scale * random.log_uniform(-1, 1));
      if (random.below(2)) s.offset_x = s.height * float(random.uniform(-1, 1));
      if (random.below(2)) s.offset_y = s.height * float(random.uniform(-1, 1));
      if (random.below(2)) {
        const double steepest = random.below(2) ? 0.4 : 1.5;
        for (float* shear : {&s.bottom_shear_x, &s.bottom_shear_y, &s.top_shear_x, &s.top_shear_y})
          *shear = float(random.uniform(-steepest, steepest));
      }
      return s;
    }
    case Kind::kCylinder:
      return core::Cylinder{length(), length()};
    case Kind::kSphere:
      return core::Sphere{length()};
    default:
      return core::Line{-length(), length()};
  }
}

/// The volume where it has a formula, else a negative number.
struct Volume {
  double operator()(const core::Pyramid& p) const {
    const double middle = 0.25 * (double(p.bottom_x) + p.top_x) * (double(p.bottom_y) + p.top_y);
    return (double(p.bottom_x) * p.bottom_y + 4.0 * middle + double(p.top_x) * p.top_y) * p.height / 6.0;
  }
  double operator()(const core::Box& b) const { return double(b.size_x) * b.size_y * b.size_z; }
  double operator()(const core::RectangularTorus& t) const {
    const double ring = double(t.outer_radius) * t.outer_radius - double(t.inner_radius) * t.inner_radius;
    return 0.5 * std::min(double(t.angle), 2.0 * kPi) * ring * t.height;
  }
  double operator()(const core::CircularTorus& t) const {
    if (t.major_radius < t.tube_radius) return -1.0;
    return std::min(double(t.angle), 2.0 * kPi) * t.major_radius * kPi * t.tube_radius * t.tube_radius;
  }
  double operator()(const core::EllipticalDish& d) const {
    return 2.0 / 3.0 * kPi * d.base_radius * d.base_radius * d.height;
  }
  double operator()(const core::SphericalDish& d) const {
    return kPi * d.height * (3.0 * double(d.base_radius) * d.base_radius + double(d.height) * d.height) / 6.0;
  }
  double operator()(const core::Snout& s) const {
    if (is_sheared(s)) return -1.0;
    const double a = s.bottom_radius, b = s.top_radius;
    return kPi * s.height * (a * a + a * b + b * b) / 3.0;
  }
  double operator()(const core::Cylinder& c) const { return kPi * c.radius * c.radius * c.height; }
  double operator()(const core::Sphere& s) const { return kPi / 6.0 * s.diameter * s.diameter * s.diameter; }
  double operator()(const core::Line&) const { return 0.0; }
};

/// Runs check(kind, primitive, random) over random primitives of every kind.
template <class Check>
void for_random_primitives(unsigned count, const Check& check) {
  for (int k = 0; k < core::kPrimitiveKindCount; ++k)
    for (unsigned seed = 0; seed < count; ++seed) {
      const Kind kind = static_cast<Kind>(k);
      SCOPED_TRACE(testing::Message() << core::name_of(kind) << ", seed " << seed);
      Random random(seed);
      check(kind, random_primitive(random, kind), random);
      if (testing::Test::HasFatalFailure()) return;
    }
}

TEST(Tessellation, IsClosedSoundAndOutward) {
  for_random_primitives(250, [](Kind kind, const Primitive& primitive, Random& random) {
    const double size = glm::length(core::bounds(primitive, {}).size());
    Tessellation config{.chord_tolerance = size * random.log_uniform(-5, 0), .max_segments = 64};
    if (random.below(4) == 0) config.fixed_segments = 3 + random.below(30);
    const core::Mesh mesh = tessellate(primitive, config);
    const auto* snout = std::get_if<core::Snout>(&primitive);
    const bool odd = snout && !has_closed_ends(*snout);  // a plane steeper than the cone may leave nothing
    if (kind != Kind::kLine && !odd) {
      ASSERT_FALSE(mesh.indices.empty());
    }
    tests::expect_sound(mesh);
    tests::expect_closed(mesh);
    // An end that is cut level besides its plane (core::EndRange) has one flat normal for both.
    if (!odd) tests::expect_normals_follow_winding(mesh, size);
    if (!core::is_degenerate(primitive)) {
      ASSERT_GE(tests::volume(mesh), -1e-6 * size * size * size);
    }
  });
}

TEST(Tessellation, VolumeConverges) {
  std::array<int, core::kPrimitiveKindCount> compared{};
  for_random_primitives(60, [&](Kind kind, const Primitive& primitive, Random&) {
    const double expected = std::visit(Volume{}, primitive);
    const double size = glm::length(core::bounds(primitive, {}).size());
    if (expected < 5e-3 * size * size * size) return;  // a sheet would need too many triangles
    const Tessellation config{.chord_tolerance = 5e-3 * expected / (size * size), .max_segments = 1 << 12};
    ASSERT_NEAR(tests::volume(tessellate(primitive, config)) / expected, 1.0, 3e-3);
    ++compared[std::size_t(kind)];
  });
  for (int k = 0; k < core::kPrimitiveKindCount - 1; ++k)
    EXPECT_GE(compared[std::size_t(k)], 3) << core::name_of(static_cast<Kind>(k));
}

TEST(Tessellation, ShearedEndsOfEqualRadiiKeepTheCylindersVolume) {
  const core::Snout s{1.0f, 1.0f, 4.0f, 0, 0, 0.3f, -0.2f, 0.5f, 0.1f};
  EXPECT_NEAR(tests::volume(tessellate(s, kFinest)) / (4.0 * kPi), 1.0, 1e-3);
}

TEST(Tessellation, CrossingEndPlanesLeaveAWedge) {
  // The planes z = -0.5 + 0.8 x and z = 0.5 - 0.8 x meet at x = 0.625, within the unit cylinder.
  const float slope = std::atan(0.8f);
  const core::Snout s{1.0f, 1.0f, 1.0f, 0, 0, slope, 0, -slope, 0};
  const core::Mesh mesh = tessellate(s, kFinest);
  tests::expect_sound(mesh);
  tests::expect_closed(mesh);
  double expected = 0.0;  // integral of top - bottom = 1 - 1.6 x over the disc's part x <= 0.625
  constexpr int kSteps = 100000;
  for (int i = 0; i < kSteps; ++i) {
    const double x = -1.0 + 1.625 * (i + 0.5) / kSteps;
    expected += (1.0 - 1.6 * x) * 2.0 * std::sqrt(1.0 - x * x) * 1.625 / kSteps;
  }
  EXPECT_NEAR(tests::volume(mesh) / expected, 1.0, 1e-3);
}

TEST(Tessellation, LiesInTheBoundsAndReachesThem) {
  for_random_primitives(25, [](Kind kind, const Primitive& primitive, Random& random) {
    const core::Mesh mesh = tessellate(primitive, kFinest);
    if (kind == Kind::kLine) return;
    core::Affine place{core::dmat3(1.0), {1.0, -2.0, 3.0}};
    for (int i = 0; i < 3; ++i) place.linear[i] += 0.5 * random.direction();
    core::AabbD box;
    for (const core::vec3& p : mesh.positions) box.grow(core::transform_point(place, dvec3(p)));
    const core::AabbD bounds = core::bounds(primitive, place);
    const double size = glm::length(bounds.size());
    const bool slack = kind == Kind::kSnout && is_sheared(std::get<core::Snout>(primitive));
    const bool spindle = kind == Kind::kCircularTorus && std::get<core::CircularTorus>(primitive).major_radius <
                                                             std::get<core::CircularTorus>(primitive).tube_radius;
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_GE(box.min[axis], bounds.min[axis] - 1e-6 * size) << "axis " << axis;
      ASSERT_LE(box.max[axis], bounds.max[axis] + 1e-6 * size) << "axis " << axis;
      if (slack || spindle) continue;
      ASSERT_LE(box.min[axis], bounds.min[axis] + 0.01 * bounds.size()[axis]) << "axis " << axis;
      ASSERT_GE(box.max[axis], bounds.max[axis] - 0.01 * bounds.size()[axis]) << "axis " << axis;
    }
  });
}

TEST(Tessellation, StaysBelowTheSupportFunction) {
  for_random_primitives(25, [](Kind, const Primitive& primitive, Random& random) {
    const core::Mesh mesh = tessellate(primitive, {.fixed_segments = 64});
    const double size = glm::length(core::bounds(primitive, {}).size());
    for (int i = 0; i < 20; ++i) {
      const dvec3 u = random.direction();
      const double support = core::support(primitive, u);
      for (const core::vec3& p : mesh.positions) ASSERT_LE(glm::dot(u, dvec3(p)), support + 1e-6 * size);
    }
  });
}

/// Distance of a point to a solid's true surface, for the kinds where that is a formula.
struct SurfaceDistance {
  dvec3 p;
  double operator()(const core::Cylinder& c) const {
    return std::min(std::fabs(c.radius - std::hypot(p.x, p.y)), 0.5 * c.height - std::fabs(p.z));
  }
  double operator()(const core::Sphere& s) const { return std::fabs(0.5 * s.diameter - glm::length(p)); }
  double operator()(const core::SphericalDish& d) const {
    const double r = (double(d.base_radius) * d.base_radius + double(d.height) * d.height) / (2.0 * d.height);
    return std::min(std::fabs(p.z), std::fabs(glm::length(p - dvec3(0, 0, d.height - r)) - r));
  }
  double operator()(const core::CircularTorus& t) const {
    double distance = std::fabs(std::hypot(std::hypot(p.x, p.y) - t.major_radius, p.z) - t.tube_radius);
    if (t.angle >= 2.0 * kPi) return distance;
    const double end = p.x * std::sin(double(t.angle)) - p.y * std::cos(double(t.angle));
    return std::min({distance, std::fabs(p.y), std::fabs(end)});
  }
  double operator()(const core::RectangularTorus& t) const {
    const double rho = std::hypot(p.x, p.y);
    const double end = p.x * std::sin(double(t.angle)) - p.y * std::cos(double(t.angle));
    return std::min({std::fabs(rho - t.inner_radius), std::fabs(rho - t.outer_radius), 0.5 * t.height - std::fabs(p.z),
                     std::fabs(p.y), std::fabs(end)});
  }
  double operator()(const core::Snout& s) const {
    const double part = p.z / s.height;
    const double r = 0.5 * (double(s.bottom_radius) + s.top_radius) + (double(s.top_radius) - s.bottom_radius) * part;
    const double lateral = std::fabs(std::hypot(p.x - part * s.offset_x, p.y - part * s.offset_y) - r);
    return std::min({lateral, 0.5 * s.height - p.z, 0.5 * s.height + p.z});
  }
  template <class T>
  double operator()(const T&) const {
    return 0.0;
  }
};

TEST(Tessellation, KeepsTheChordTolerance) {
  for_random_primitives(120, [](Kind kind, const Primitive& primitive, Random& random) {
    if (kind == Kind::kSnout && is_sheared(std::get<core::Snout>(primitive))) return;
    const double size = glm::length(core::bounds(primitive, {}).size());
    const Tessellation config{
        .chord_tolerance = size * random.log_uniform(-3.5, 0), .min_segments = 3, .max_segments = 1 << 14};
    const core::Mesh mesh = tessellate(primitive, config);
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      const dvec3 a(mesh.positions[mesh.indices[i]]), b(mesh.positions[mesh.indices[i + 1]]),
          c(mesh.positions[mesh.indices[i + 2]]);
      for (const dvec3& p : {0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (a + b + c) / 3.0})
        ASSERT_LE(std::visit(SurfaceDistance{p}, primitive), config.chord_tolerance + 1e-6 * size)
            << "triangle " << i / 3;
    }
  });
}

/// First crossing of a ray from outside with the triangles (Moller and Trumbore), or infinity.
double first_hit(const core::Mesh& mesh, const Ray& ray) {
  double first = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const dvec3 a(mesh.positions[mesh.indices[i]]);
    const dvec3 e1 = dvec3(mesh.positions[mesh.indices[i + 1]]) - a,
                e2 = dvec3(mesh.positions[mesh.indices[i + 2]]) - a;
    const dvec3 h = glm::cross(ray.direction, e2);
    const double det = glm::dot(e1, h);
    if (det == 0.0) continue;
    const dvec3 s = ray.origin - a, q = glm::cross(s, e1);
    const double u = glm::dot(s, h) / det, v = glm::dot(ray.direction, q) / det;
    if (u >= 0.0 && v >= 0.0 && u + v <= 1.0) first = std::min(first, glm::dot(e2, q) / det);
  }
  return first;
}

Hits intersect_any(const Primitive& p, const Ray& ray) {
  if (const auto* c = std::get_if<core::Cylinder>(&p)) return intersect(*c, ray);
  if (const auto* s = std::get_if<core::Snout>(&p)) return intersect(*s, ray);
  return intersect(std::get<core::CircularTorus>(p), ray);
}

TEST(Tessellation, AgreesWithTheIntersection) {
  for (const Kind kind : {Kind::kCylinder, Kind::kSnout, Kind::kCircularTorus}) {
    int rays = 0, compared = 0, apart = 0;
    for (unsigned seed = 0; seed < 60; ++seed) {
      Random random(seed);
      const Primitive primitive = random_primitive(random, kind);
      if (kind == Kind::kSnout && !has_closed_ends(std::get<core::Snout>(primitive))) continue;
      const core::AabbD box = core::bounds(primitive, {});
      const double size = glm::length(box.size()), tolerance = 1e-4 * size;
      const core::Mesh mesh = tessellate(primitive, {.chord_tolerance = tolerance, .max_segments = 1 << 12});
      for (int i = 0; i < 25; ++i, ++rays) {
        const dvec3 target =
            box.centre() +
            0.4 * box.size() * dvec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        const dvec3 direction = random.direction();
        const Ray ray{target - 3.0 * size * direction, direction};
        const Hits hits = intersect_any(primitive, ray);
        const double triangles = first_hit(mesh, ray);
        if (hits.count == 0 && !std::isfinite(triangles)) continue;
        ++compared;
        // Grazing rays see the chord error enlarged; where a silhouette moves they may even pass.
        const double facing = hits.count ? std::fabs(glm::dot(glm::normalize(hits.hit[0].normal), direction)) : 0.0;
        if (facing < 0.2 && (hits.count == 0 || !std::isfinite(triangles))) continue;
        apart += !(hits.count && std::fabs(hits.hit[0].t - triangles) <= 2.0 * tolerance / std::max(facing, 0.02));
      }
    }
    SCOPED_TRACE(core::name_of(kind));
    EXPECT_GT(compared, rays / 5);
    EXPECT_LE(apart, compared / 100) << "of " << compared;
  }
}

TEST(Tessellation, SegmentCountFollowsTheTolerance) {
  const Tessellation millimetre{.chord_tolerance = 1.0, .min_segments = 3, .max_segments = 1000};
  EXPECT_EQ(segment_count(millimetre, 100.0, 2.0 * kPi), int(std::ceil(2.0 * kPi / std::acos(0.99))));
  EXPECT_EQ(segment_count(millimetre, 100.0, 0.5 * kPi), int(std::ceil(0.5 * kPi / std::acos(0.99))));
  EXPECT_EQ(segment_count(millimetre, 1.0, 2.0 * kPi), 4) << "tolerance = radius: right angles";
  EXPECT_EQ(segment_count(millimetre, 0.1, 2.0 * kPi), 3) << "tolerance beyond the diameter";
  EXPECT_EQ(segment_count(millimetre, 0.0, 2.0 * kPi), 3);
  EXPECT_EQ(segment_count(millimetre, 1e30, 2.0 * kPi), 1000);
  EXPECT_EQ(segment_count({.chord_tolerance = 0.0}, 1.0, 2.0 * kPi), 256);
  EXPECT_EQ(segment_count({.chord_tolerance = std::numeric_limits<double>::quiet_NaN()}, 1.0, 2.0 * kPi), 256);
  EXPECT_EQ(segment_count({.fixed_segments = 12}, 1.0, double(float(2.0 * kPi))), 12);
  EXPECT_EQ(segment_count({.fixed_segments = 12}, 1.0, double(float(0.5 * kPi))), 3);
  EXPECT_EQ(segment_count({.fixed_segments = 6}, 1.0, 0.01), 1);
  EXPECT_EQ(segment_count({.fixed_segments = 1}, 1.0, 2.0 * kPi), 3);
}

TEST(Tessellation, DegeneratePrimitivesShowWhatTheyAre) {
  const Primitive empty[] = {core::Cylinder{0, 1},
                             core::Sphere{0},
                             core::EllipticalDish{0, 1},
                             core::SphericalDish{0, 0},
                             core::Snout{0, 0, 1, 0, 0, 0, 0, 0, 0},
                             core::CircularTorus{1, 0, 1},
                             core::RectangularTorus{1, 1, 0, 1},
                             core::Box{1, 0, 0},
                             core::Pyramid{1, 0, 1, 0, 0, 0, 0},
                             core::Line{0, 1},
                             core::Cylinder{std::numeric_limits<float>::quiet_NaN(), 1},
                             core::Box{std::numeric_limits<float>::infinity(), 1, 1}};
  for (const Primitive& p : empty) {
    const core::Mesh mesh = tessellate(p);
    EXPECT_TRUE(mesh.indices.empty() && mesh.positions.empty()) << core::name_of(core::kind_of(p));
  }
  const Primitive sheets[] = {core::Cylinder{1, 0},
                              core::EllipticalDish{1, 0},
                              core::SphericalDish{1, 0},
                              core::Snout{1, 2, 0, 3, 0, 0.5f, 0, 0, 0},
                              core::CircularTorus{2, 1, 0},
                              core::RectangularTorus{1, 2, 0, 1},
                              core::RectangularTorus{1, 1, 2, 1},
                              core::RectangularTorus{1, 2, 2, 0},
                              core::Box{1, 1, 0},
                              core::Pyramid{1, 1, 1, 1, 0, 0, 0}};
  for (const Primitive& p : sheets) {
    SCOPED_TRACE(core::name_of(core::kind_of(p)));
    const core::Mesh mesh = tessellate(p);
    EXPECT_FALSE(mesh.indices.empty());
    tests::expect_sound(mesh);
    tests::expect_closed(mesh);
    EXPECT_NEAR(tests::volume(mesh), 0.0, 1e-6);
  }
  EXPECT_EQ(tessellate(core::Sphere{1}).positions, tessellate(core::Sphere{-1}).positions);
  EXPECT_EQ(tessellate(core::Snout{1, 2, 3, 1, 0, 0, 0, 0, 0}).positions,
            tessellate(core::Snout{-1, -2, -3, 1, 0, 0, 0, 0, 0}).positions);
}

TEST(Tessellation, OpenEndsHaveARim) {
  const Primitive whole[] = {core::Cylinder{1, 2}, core::Snout{1, 2, 3, 0.5f, 0, 0.1f, 0, 0, 0},
                             core::CircularTorus{3, 1, 1}, core::RectangularTorus{2, 3, 1, 1}};
  for (const Primitive& p : whole) {
    const std::size_t closed = tessellate(p).indices.size();
    const std::size_t no_top = tessellate(p, {}, {true, false}).indices.size();
    const std::size_t no_bottom = tessellate(p, {}, {false, true}).indices.size();
    const std::size_t open = tessellate(p, {}, {false, false}).indices.size();
    EXPECT_LT(no_top, closed) << core::name_of(core::kind_of(p));
    EXPECT_EQ(no_top + no_bottom, closed + open) << core::name_of(core::kind_of(p));
  }
}

}  // namespace
}  // namespace sightline::gpuprims::tessellation_test
