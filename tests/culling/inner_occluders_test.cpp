// The occluder polygons within solids and the quads in front of them against the solids themselves. An occluder polygon
// lies within its solid by the margins asked for, and its corners by hardly more. Each line of sight to a solid crosses
// a quad in front of it, and hardly any other does.
#include "sightline/culling/occlusion/internal/inner_occluders.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <variant>

#include <gtest/gtest.h>

#include "scenes.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::tests::inner_occluders_test {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec3;
using core::Kind;
using core::Primitive;
using culling::EyeProjection;
using culling::OccluderPolygon;

constexpr double kNever = std::numeric_limits<double>::infinity();

double square(double a) {
  return a * a;
}

/// Whether solids hold a point. Lengths are larger by `room`. What `share` is a margin of is smaller by that: radii,
/// and all lengths of solids that are not round about an axis.
struct Holds {
  dvec3 p;
  double room, share = 0.0;

  double across() const { return std::hypot(p.x, p.y); }
  bool in_sweep(float angle) const {
    const double sweep = core::sweep_angle(angle), at = std::atan2(p.y, p.x);
    const double slack = room / std::max(1e-30, across());
    return sweep >= core::kFullTurn || (at < 0.0 && at >= -slack) ||
           at + (at < 0.0 ? core::kFullTurn : 0.0) <= sweep + slack;
  }
  bool operator()(const core::Pyramid& s) const {
    const double t = p.z / s.height + 0.5;
    return std::abs(p.z) <= 0.5 * s.height + room &&
           std::abs(p.x - (t - 0.5) * s.offset_x) <=
               0.5 * std::lerp(double(s.bottom_x), double(s.top_x), t) + room - share &&
           std::abs(p.y - (t - 0.5) * s.offset_y) <=
               0.5 * std::lerp(double(s.bottom_y), double(s.top_y), t) + room - share;
  }
  bool operator()(const core::Box& s) const {
    return std::abs(p.x) <= 0.5 * s.size_x + room - share && std::abs(p.y) <= 0.5 * s.size_y + room - share &&
           std::abs(p.z) <= 0.5 * s.size_z + room - share;
  }
  bool operator()(const core::RectangularTorus& s) const {
    return std::abs(p.z) <= 0.5 * s.height + room - share && across() >= s.inner_radius - room + share &&
           across() <= s.outer_radius + room - share && in_sweep(s.angle);
  }
  bool operator()(const core::CircularTorus& s) const {
    return std::hypot(across() - s.major_radius, p.z) <= s.tube_radius + room - share && in_sweep(s.angle);
  }
  bool operator()(const core::EllipticalDish& s) const {
    return p.z >= -room && square(across() / s.base_radius) + square(p.z / s.height) <=
                               square(1.0 + (room - share) / std::min(s.base_radius, s.height));
  }
  bool operator()(const core::SphericalDish& s) const {
    const double radius = (square(s.base_radius) + square(s.height)) / (2.0 * s.height);
    return p.z >= -room && std::hypot(across(), p.z - s.height + radius) <= radius + room - share;
  }
  bool operator()(const core::Snout& s) const {
    const double t = p.z / s.height + 0.5, x = p.x - (t - 0.5) * s.offset_x, y = p.y - (t - 0.5) * s.offset_y;
    const double low = -0.5 * s.height + std::tan(s.bottom_shear_x) * (p.x + 0.5 * s.offset_x) +
                       std::tan(s.bottom_shear_y) * (p.y + 0.5 * s.offset_y);
    const double high = 0.5 * s.height + std::tan(s.top_shear_x) * (p.x - 0.5 * s.offset_x) +
                        std::tan(s.top_shear_y) * (p.y - 0.5 * s.offset_y);
    return p.z >= low - room && p.z <= high + room &&
           std::hypot(x, y) <= std::lerp(double(s.bottom_radius), double(s.top_radius), t) + room - share;
  }
  bool operator()(const core::Cylinder& s) const {
    return std::abs(p.z) <= 0.5 * s.height + room && across() <= s.radius + room - share;
  }
  bool operator()(const core::Sphere& s) const { return glm::length(p) <= 0.5 * s.diameter + room - share; }
  bool operator()(const core::Line&) const { return false; }
};

/// A length of a solid of which the margin `of_radius` is a share.
struct RadiusOf {
  double operator()(const core::Pyramid& s) const { return 0.5 * std::max({s.bottom_x, s.bottom_y, s.top_x, s.top_y}); }
  double operator()(const core::Box& s) const { return 0.5 * std::min({s.size_x, s.size_y, s.size_z}); }
  double operator()(const core::RectangularTorus& s) const { return s.outer_radius; }
  double operator()(const core::CircularTorus& s) const { return 4.0 * s.tube_radius + 0.025 * s.major_radius; }
  double operator()(const core::EllipticalDish& s) const { return std::min(s.base_radius, s.height); }
  double operator()(const core::SphericalDish& s) const { return std::min(s.base_radius, s.height); }
  double operator()(const core::Snout& s) const {
    const bool slanted = s.bottom_shear_x != 0 || s.bottom_shear_y != 0 || s.top_shear_x != 0 || s.top_shear_y != 0;
    return (slanted ? 0.1 : 1.0) * std::max(s.bottom_radius, s.top_radius);  // ends may be cut off
  }
  double operator()(const core::Cylinder& s) const { return s.radius; }
  double operator()(const core::Sphere& s) const { return 0.5 * s.diameter; }
  double operator()(const core::Line&) const { return 0.0; }
};

double size_of(const Primitive& solid) {
  return glm::length(core::bounds(solid, {}).size());
}

/// About 1 in size. Snouts may have slanted ends.
Primitive random_solid(Kind kind, Random& random) {
  const auto length = [&] { return float(magnitude(random, chance(random, 0.2) ? 0.02 : 0.3, 2.0)); };
  const auto shift = [&] { return chance(random, 0.5) ? 0.0f : float(uniform(random, -1.0, 1.0)); };
  const auto angle = [&] { return chance(random, 0.2) ? 6.2831855f : float(uniform(random, 0.05, 6.2)); };
  Primitive made = primitive_of(kind, length, shift, angle);
  if (auto* torus = std::get_if<core::CircularTorus>(&made))
    torus->tube_radius = torus->major_radius * float(magnitude(random, 2e-3, 0.99));
  if (auto* snout = std::get_if<core::Snout>(&made); snout && chance(random, 0.4)) {
    const auto slant = [&] { return chance(random, 0.5) ? 0.0f : float(uniform(random, -0.3, 0.3)); };
    snout->bottom_shear_x = slant(), snout->bottom_shear_y = slant();
    snout->top_shear_x = slant(), snout->top_shear_y = slant();
  }
  return made;
}

using Triangle = std::array<dvec3, 3>;

/// Appends the fan from a corner of a polygon, or of each face of a hexahedron.
void append_triangles(const OccluderPolygon& polygon, std::size_t first, std::vector<Triangle>& out) {
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    out.push_back({polygon.corners[a], polygon.corners[b], polygon.corners[c]});
  };
  if (!polygon.hexahedron) {
    const auto n = std::size_t(polygon.count);
    for (std::size_t i = 1; i + 1 < n; ++i) add(first, (first + i) % n, (first + i + 1) % n);
    return;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t next = (i + 1) % 4;
    add(i, next, next + 4), add(i, next + 4, i + 4);
  }
  add(0, 1, 2), add(0, 2, 3), add(4, 5, 6), add(4, 6, 7);
}

/// Where a line of sight from 0 on crosses a triangle, as a multiple of `along`.
std::optional<double> crossing(const Triangle& t, const dvec3& at, const dvec3& along) {
  const dvec3 u = t[1] - t[0], v = t[2] - t[0], normal = glm::cross(u, v), to = at - t[0];
  const double whole_area = glm::dot(normal, along);
  const double b = glm::dot(glm::cross(to, v), along) / whole_area, c = glm::dot(glm::cross(u, to), along) / whole_area;
  if (!(b >= 0.0 && c >= 0.0 && b + c <= 1.0)) return std::nullopt;
  return -glm::dot(normal, to) / whole_area;
}

/// Axes outwards from z, around it and along it.
dmat3 around(const dvec3& p) {
  const double across = std::hypot(p.x, p.y);
  if (!(across > 0.0)) return dmat3(1.0);
  return {{p.x / across, p.y / across, 0.0}, {-p.y / across, p.x / across, 0.0}, {0.0, 0.0, 1.0}};
}

/// A solid in front of the eye, which is the origin. Some placements are uneven or mirror.
struct Seen {
  Primitive solid;
  Affine place;
  dmat3 inverse;
  EyeProjection projection;

  Seen(Kind kind, Random& random) : solid(random_solid(kind, random)) {
    place.linear = random_rotation(random);
    place.linear *= magnitude(random, 0.3, 3.0);
    if (chance(random, 0.3)) place.linear[whole(random, 0, 2)] *= -uniform(random, 0.4, 2.0);
    if (chance(random, 0.2)) place.linear[0] += 0.4 * place.linear[1];
    if (chance(random, 0.1)) place.linear = dmat3(1.0);
    place.origin = random_direction(random);
    place.origin *= magnitude(random, 4.0, 30.0) * size_of(solid);
    inverse = glm::inverse(place.linear);
    projection = {chance(random, 0.6), random_direction(random)};
  }
  dvec3 in_item(const dvec3& p) const { return inverse * (p - place.origin); }
  /// The line of sight through a point, in the solid's coordinates, from in front of it.
  core::Ray ray(const dvec3& through) const {
    if (projection.perspective) return {in_item(dvec3(0.0)), inverse * through};
    return {in_item(through - 100.0 * projection.forward), 100.0 * inverse * projection.forward};
  }
  /// As a multiple of the ray's direction; kNever: none.
  double first_crossing(std::span<const Triangle> triangles, const dvec3& through) const {
    const dvec3 at = projection.perspective ? dvec3(0.0) : through - 100.0 * projection.forward;
    double first = kNever;
    for (const Triangle& t : triangles)
      if (const auto s = crossing(t, at, projection.perspective ? through : 100.0 * projection.forward))
        first = std::min(first, *s);
    return first;
  }
  bool holds(const dvec3& own, double room, double share = 0.0) const {
    return std::visit(Holds{own, room, share}, solid);
  }
  /// Whether the solid holds whatever is no farther away than `metres`, and `of_radius` of its radius, across.
  bool holds_around(const dvec3& own, double of_radius, double metres) const {
    const double slack = 1e-9 * size_of(solid);
    if (!holds(own, slack, of_radius * std::visit(RadiusOf{}, solid))) return false;
    double along = metres;  // a sweep
    if (core::kind_of(solid) == Kind::kRectangularTorus) along *= 0.95;
    if (const auto* torus = std::get_if<core::CircularTorus>(&solid))
      along *= 0.95 * (1.0 - torus->tube_radius / torus->major_radius);
    const dmat3 frame = around(own);
    for (int k = 1; k < 27; ++k) {
      const dvec3 to(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      if (to == dvec3(0.0)) continue;
      const dvec3 step = frame * to;
      if (!holds(own + (to.y == 0.0 ? metres : along) / glm::length(place.linear * step) * step, slack)) return false;
    }
    return true;
  }
  std::vector<OccluderPolygon> polygons(double of_radius, double metres) const {
    std::vector<OccluderPolygon> found;
    culling::add_inner_occluders(core::kind_of(solid), core::parameters(solid).data(), place, projection, of_radius,
                                 metres, found);
    return found;
  }
};

dvec3 random_point_of(const Triangle& t, Random& random) {
  double b = uniform(random, 0.0, 1.0), c = uniform(random, 0.0, 1.0);
  if (b + c > 1.0) b = 1.0 - b, c = 1.0 - c;
  return t[0] + b * (t[1] - t[0]) + c * (t[2] - t[0]);
}

constexpr Kind kSolids[] = {
    Kind::kPyramid,       Kind::kBox,   Kind::kRectangularTorus, Kind::kCircularTorus, Kind::kEllipticalDish,
    Kind::kSphericalDish, Kind::kSnout, Kind::kCylinder,         Kind::kSphere};

class InnerOccludersOf : public testing::TestWithParam<Kind> {};

/// What chords of arcs take from the cross section of a torus, at most.
double sagitta_of(const Primitive& solid) {
  constexpr double kLeast = 1.26e-3;  // of a radius: that of a tenth radian
  if (const auto* torus = std::get_if<core::CircularTorus>(&solid))
    return std::max(0.1 * torus->tube_radius, kLeast * torus->major_radius);
  if (const auto* torus = std::get_if<core::RectangularTorus>(&solid))
    return std::max(0.053 * (torus->outer_radius - torus->inner_radius), kLeast * torus->inner_radius);
  return 0.0;
}

TEST_P(InnerOccludersOf, LieWithinByTheirMargins) {
  std::size_t some = 0, none = 0;
  for (std::uint64_t seed = 1; seed <= 1500; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Seen seen(GetParam(), random);
    const double of_radius = chance(random, 0.3) ? 0.0 : magnitude(random, 1e-3, 0.3);
    const double metres = chance(random, 0.3) ? 0.0
                                              : magnitude(random, 1e-3, 0.3) * size_of(seen.solid) *
                                                    std::cbrt(std::abs(glm::determinant(seen.place.linear)));
    const std::vector<OccluderPolygon> polygons = seen.polygons(of_radius, metres);
    ++(polygons.empty() ? none : some);
    for (const OccluderPolygon& polygon : polygons) {
      if (polygon.hexahedron) {  // corners 0 to 3 turn left as seen from the other face
        const auto& c = polygon.corners;
        ASSERT_EQ(polygon.count, 8);
        ASSERT_GT(glm::dot(glm::cross(c[1] - c[0], c[3] - c[0]), c[4] - c[0]), 0.0);
      }
      const auto lies_within = [&](std::size_t first) {
        std::vector<Triangle> triangles;
        append_triangles(polygon, first, triangles);
        for (const Triangle& t : triangles)
          for (int i = 0; i < 5; ++i)
            if (!seen.holds_around(seen.in_item(i < 3 ? t[std::size_t(i)] : random_point_of(t, random)), of_radius,
                                   metres))
              return false;
        return true;
      };
      ASSERT_TRUE(lies_within(0) || (polygon.count == 4 && lies_within(1)))
          << "margins " << of_radius << " " << metres << " of " << size_of(seen.solid);
    }
  }
  EXPECT_GT(some, 500u);
  RecordProperty("none", int(none));
  RecordProperty("some", int(some));
}

/// So large that occluder polygons without margins reach the surface, and with margins not much less.
TEST_P(InnerOccludersOf, TouchTheirSolids) {
  for (std::uint64_t seed = 1; seed <= 1500; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Seen seen(GetParam(), random);
    const double size = size_of(seen.solid);
    const bool exact = chance(random, 0.5);
    if (!exact && std::visit(RadiusOf{}, seen.solid) < 0.1 * size) continue;
    const double of_radius = exact ? 0.0 : 2e-3,
                 metres = exact ? 0.0 : 1e-3 * size * std::cbrt(std::abs(glm::determinant(seen.place.linear)));
    for (const OccluderPolygon& polygon : seen.polygons(of_radius, metres)) {
      for (std::size_t i = 0; i < std::size_t(polygon.count); ++i) {
        const dvec3 own = seen.in_item(polygon.corners[i]);
        const double room = 1.01 * sagitta_of(seen.solid) + (exact ? 1e-6 : 0.05) * size;
        bool leaves = false;
        for (int k = 1; k < 27; ++k) {
          const dvec3 to = around(own) * dvec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
          for (const double far : {1.0, 0.5, 0.1}) leaves = leaves || !seen.holds(own + far * room * to, 0.0);
        }
        ASSERT_TRUE(leaves) << "corner " << i << " at " << own.x << " " << own.y << " " << own.z;
      }
    }
  }
}

/// For each kind, the shares of lines of sight to solids that occluder polygons cover, and of these that meet them
/// beyond six tenths of the way through the solid.
struct Shares {
  double covered, late;
};
Shares shares_of(Kind kind) {
  switch (kind) {
    case Kind::kRectangularTorus:
      return {0.70, 0.12};
    case Kind::kCircularTorus:
      return {0.81, 0.06};
    case Kind::kEllipticalDish:
      return {0.875, 0.305};
    case Kind::kSphericalDish:
      return {0.82, 0.315};
    case Kind::kSnout:
      return {0.805, 0.29};
    case Kind::kCylinder:
      return {0.925, 0.2};
    case Kind::kSphere:
      return {0.925, 0.01};
    default:
      return {1.0, 0.0};
  }
}

TEST_P(InnerOccludersOf, HideNearlyWhatTheirSolidsHide) {
  std::size_t met = 0, covered = 0, late = 0;
  for (std::uint64_t seed = 1; seed <= 1500; ++seed) {
    Random random(seed);
    const Seen seen(GetParam(), random);
    std::vector<Triangle> triangles;
    for (const OccluderPolygon& polygon : seen.polygons(0.0, 0.0)) append_triangles(polygon, 0, triangles);
    const core::AabbD box = core::bounds(seen.solid, seen.place);
    for (int i = 0; i < 120; ++i) {
      const dvec3 through = box.centre() + box.size() * point(random, 0.5);
      const gpuprims::Hits hits = gpuprims::intersect(seen.solid, seen.ray(through));
      if (hits.count < 2 || hits.hit[0].t < 0.0) continue;
      ++met;
      const double first = seen.first_crossing(triangles, through);
      covered += first < kNever;
      late += first < kNever && first > hits.hit[0].t + 0.6 * (hits.hit[1].t - hits.hit[0].t);
    }
  }
  const Shares shares = shares_of(GetParam());
  EXPECT_GT(met, 40'000u);
  EXPECT_GE(double(covered) / double(met), shares.covered - 1e-5);
  EXPECT_LE(double(late) / double(covered), shares.late + 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Kinds, InnerOccludersOf, testing::ValuesIn(kSolids),
                         [](const auto& kind) { return std::string(core::name_of(kind.param)); });

// --- quads in front -----------------------------------------------------------------------------------------------

/// A cylinder between two points, in a solid's coordinates.
struct Tube {
  dvec3 a, b;
  double radius;

  /// Where a line enters it, as a multiple of the direction; kNever: it passes by, by more than a billionth or so.
  double entry(const core::Ray& ray) const {
    const dvec3 axis = (b - a) / glm::length(b - a), to = ray.origin - a;
    const double at = glm::dot(to, axis), rate = glm::dot(ray.direction, axis), length = glm::length(b - a);
    double first = std::min(-at / rate, (length - at) / rate), last = std::max(-at / rate, (length - at) / rate);
    const dvec3 p = to - at * axis, d = ray.direction - rate * axis;
    const double dd = glm::dot(d, d), middle = -glm::dot(p, d) / dd;
    const double square_left = square(radius) - glm::dot(p + middle * d, p + middle * d);
    if (square_left < 0.0) return kNever;
    const double half = std::sqrt(square_left / dd);
    first = std::max(first, middle - half), last = std::min(last, middle + half);
    return first <= last ? first : kNever;
  }
};

/// What quads in front stand for: the solid, larger by margins; of a torus, tubes about equal chords of its centre
/// line, of half a radian at most. Empty: there are none.
std::vector<Tube> tubes_of(const Primitive& solid, double of_radius, double metres) {
  const auto larger = [&](const dvec3& a, const dvec3& b, double radius, double beyond) {
    const double lost = of_radius * radius + metres;
    const dvec3 along = (beyond + lost) * glm::normalize(b - a);
    return Tube{a - along, b + along, radius + lost};
  };
  if (const auto* cylinder = std::get_if<core::Cylinder>(&solid)) {
    const dvec3 up(0.0, 0.0, 0.5 * cylinder->height);
    return {larger(-up, up, cylinder->radius, 0.0)};
  }
  if (const auto* snout = std::get_if<core::Snout>(&solid)) {
    for (std::size_t i = 3; i < 9; ++i)
      if (core::parameters(solid)[i] != 0.0f) return {};
    const dvec3 up(0.0, 0.0, 0.5 * snout->height);
    return {larger(-up, up, std::max(snout->bottom_radius, snout->top_radius), 0.0)};
  }
  const auto* torus = std::get_if<core::CircularTorus>(&solid);
  if (!torus) return {};
  const double sweep = core::sweep_angle(torus->angle), major = torus->major_radius, tube = torus->tube_radius;
  const int count = std::max(1, int(std::ceil(sweep / 0.5)));
  const double half = 0.5 * sweep / count;
  std::vector<Tube> tubes;
  for (int i = 0; i < count; ++i) {
    const double from = 2.0 * half * i, to = 2.0 * half * (i + 1);
    tubes.push_back(larger(major * dvec3(std::cos(from), std::sin(from), 0.0),
                           major * dvec3(std::cos(to), std::sin(to), 0.0), tube + major * (1.0 - std::cos(half)),
                           tube * std::sin(half)));
  }
  return tubes;
}

/// How the eye sees a tube: heights over the axis, in radii, and how far it is beyond an end, in lengths and radii.
struct Outlook {
  double height, beyond;
};
Outlook outlook(const Seen& seen, const Tube& tube) {
  const double length = glm::length(tube.b - tube.a);
  const dvec3 axis = (tube.b - tube.a) / length;
  const dvec3 eye =
      seen.projection.perspective ? seen.in_item(dvec3(0.0)) - tube.a : -seen.inverse * seen.projection.forward;
  const double at = glm::dot(eye, axis), height = glm::length(eye - at * axis);
  if (!seen.projection.perspective) return {kNever, 2.0 * tube.radius * std::abs(at) / height / (length + tube.radius)};
  return {height / tube.radius, std::max(-at, at - length) / (length + tube.radius)};
}

/// Lines of sight through the middle of each side of a quad, a little within, touch the tube; a little outside, they
/// pass it by. Those to points of the tube cross the quad first.
void expect_tight(const Seen& seen, const Tube& tube, const OccluderPolygon& quad, Random& random) {
  constexpr double kLittle = 1e-5;
  const dvec3 middle = 0.25 * (quad.corners[0] + quad.corners[1] + quad.corners[2] + quad.corners[3]);
  for (std::size_t i = 0; i < 4; ++i) {
    const dvec3 side = 0.5 * (quad.corners[i] + quad.corners[(i + 1) % 4]);
    ASSERT_LT(tube.entry(seen.ray(middle + (1.0 - kLittle) * (side - middle))), kNever) << "side " << i;
    ASSERT_EQ(tube.entry(seen.ray(middle + (1.0 + kLittle) * (side - middle))), kNever) << "side " << i;
  }
  std::vector<Triangle> triangles;
  append_triangles(quad, 0, triangles);
  for (int i = 0; i < 20; ++i) {
    const double angle = uniform(random, 0.0, 6.3), at = std::clamp(uniform(random, -0.3, 1.3), 0.0, 1.0);
    const dvec3 axis = glm::normalize(tube.b - tube.a);
    const dvec3 u = glm::normalize(glm::cross(axis, random_direction(random))), v = glm::cross(axis, u);
    const dvec3 own =
        tube.a + at * (tube.b - tube.a) + (1.0 - 1e-7) * tube.radius * (std::cos(angle) * u + std::sin(angle) * v);
    const dvec3 through = core::transform_point(seen.place, own);
    const double entry = tube.entry(seen.ray(through)), crossed = seen.first_crossing(triangles, through);
    ASSERT_LE(crossed, entry + 1e-7 * std::abs(entry)) << "point " << i;
  }
}

class SolidFrontsOf : public testing::TestWithParam<Kind> {};

TEST_P(SolidFrontsOf, AreWhereTheirSolidsAreSeenFirst) {
  int with = 0, without = 0;
  for (std::uint64_t seed = 1; seed <= 1500; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    Seen seen(GetParam(), random);
    // Nothing but scale, so that metres are the same in the solid's coordinates; perhaps near, and along the axis.
    const double scale = magnitude(random, 0.2, 5.0);
    seen.place.linear = dmat3(scale);
    seen.inverse = dmat3(1.0 / scale);
    if (auto* snout = std::get_if<core::Snout>(&seen.solid); snout && chance(random, 0.8))
      *snout = {snout->bottom_radius, snout->top_radius, snout->height, 0, 0, 0, 0, 0, 0};
    seen.place.origin = random_direction(random);
    seen.place.origin *= scale * size_of(seen.solid) * magnitude(random, 0.1, 30.0);
    if (chance(random, 0.2)) seen.place.origin.x = seen.place.origin.y = 0.01;
    const double of_radius = chance(random, 0.5) ? 0.0 : magnitude(random, 1e-3, 0.2);
    const double metres = chance(random, 0.5) ? 0.0 : magnitude(random, 1e-3, 0.2) * size_of(seen.solid) * scale;
    std::vector<OccluderPolygon> quads;
    const bool found = culling::add_fronts(GetParam(), core::parameters(seen.solid).data(), seen.place, seen.projection,
                                           of_radius, metres, quads);
    const std::vector<Tube> tubes = tubes_of(seen.solid, of_radius, metres / scale);
    ++(found ? with : without);
    if (!found) {
      const bool known = std::all_of(tubes.begin(), tubes.end(), [&](const Tube& tube) {
        const Outlook from = outlook(seen, tube);
        return from.height > 1.06 && from.beyond < 2.9;
      });
      ASSERT_FALSE(known && !tubes.empty()) << "none, though all is well seen";
      continue;
    }
    ASSERT_EQ(quads.size(), tubes.size());
    for (std::size_t i = 0; i < tubes.size(); ++i) {
      ASSERT_GT(outlook(seen, tubes[i]).height, 1.04);
      const double long_by = glm::length(quads[i].corners[2] - quads[i].corners[1]) / scale;
      ASSERT_LT(long_by, 4.01 * (glm::length(tubes[i].b - tubes[i].a) + tubes[i].radius));
      ASSERT_NO_FATAL_FAILURE(expect_tight(seen, tubes[i], quads[i], random)) << "quad " << i;
    }
    // The tubes hold the solid, larger by its margins.
    for (int i = 0; i < 20; ++i) {
      const dvec3 own = (1.0 - 1e-7) * random_point(seen.solid, random);
      ASSERT_TRUE(std::any_of(tubes.begin(), tubes.end(), [&](const Tube& tube) {
        return tube.entry(seen.ray(core::transform_point(seen.place, own))) < kNever;
      }));
    }
  }
  EXPECT_GT(with, 600);
  EXPECT_GT(without, 30);
}

INSTANTIATE_TEST_SUITE_P(Kinds, SolidFrontsOf, testing::Values(Kind::kCylinder, Kind::kSnout, Kind::kCircularTorus),
                         [](const auto& kind) { return std::string(core::name_of(kind.param)); });

TEST(SolidFronts, NoneOfOtherKinds) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Random random(seed);
    for (const Kind kind : kSolids) {
      if (kind == Kind::kCylinder || kind == Kind::kSnout || kind == Kind::kCircularTorus) continue;
      const Seen seen(kind, random);
      std::vector<OccluderPolygon> quads;
      EXPECT_FALSE(
          culling::add_fronts(kind, core::parameters(seen.solid).data(), seen.place, seen.projection, 0.0, 0.0, quads));
    }
  }
}

}  // namespace
}  // namespace sightline::tests::inner_occluders_test
