#include "sightline/apps/bench/stability/cases.h"

#include <algorithm>
#include <cstdio>

#include <glm/gtc/matrix_transform.hpp>

namespace sightline::bench {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec3;
using core::Kind;
using core::Primitive;

// --- limits ----------------------------------------------------------------------------------------------------------
// These are the project's targets where there are any, and similar limits everywhere else. An error may grow with the
// size, in radii, of numbers that a computation near the primitive cannot avoid (the solid's extent, the eye's distance
// in t), and with nothing else.

constexpr double kDoubleStep = 0x1p-53, kFloatStep = 0x1p-24;  // half an ulp of 1

/// Target: 1e-12 r, 1e-9 r for an eye 1e5 r away, 1e-8 r at r/L = 1e-6, no wrong result outside 1e-12 r. `magnitude`:
/// of the largest length involved, in radii. If a position is off by half an ulp of it, a tie moves as much. The band
/// is four such roundings (origin, direction, an end's height, a product).
Limits wide_limits(double magnitude) {
  const double t = std::max(1e-12, 1e-14 * magnitude);
  return {t, 10.0 * t, std::max(1e-12, 8.0 * kDoubleStep * magnitude), 0.0};
}

/// Target: 5e-5 r for all but the circular torus, which has 1e-4 r, 0.02 % wrong, and at R/r = 1e3 1e-2 r and 0.1 %.
/// `magnitude`: of the solid's length in radii. Moving along the solid's axis keeps the ray's numbers small, but the
/// position of an end is only known to half an ulp. The eye's distance does not matter: t is added up in double.
Limits single_limits(Kind kind, double magnitude) {
  const double band = 8.0 * kFloatStep * magnitude;
  const bool torus = kind == Kind::kCircularTorus;
  const double t = (torus ? 1e-4 : 5e-5) + (magnitude > 1.0 ? band : 0.0);
  return {t, 10.0 * t, band, torus ? 2e-4 : 0.0};
}

/// For a solid that no shift brings near, such as a hoop. Coordinates of its own size are rounded four times. One ray
/// in 1e5 meets the surface so flatly that this costs 200 times as much: 900 half ulps, which is also the float target
/// of ordinary solids.
void allow_reach(Limits& wide, Limits& single, double reach) {
  wide = wide_limits(10.0 * reach);
  single.band = 8.0 * kFloatStep * std::max(1.0, reach);
  single.t = std::max(single.t, (single.wrong > 0.0 ? 1e-5 : 5e-5) * reach);
  single.normal = 10.0 * single.t;
  if (single.wrong > 0.0 && reach > 100.0) single.wrong = 1e-3;
}

// --- rays ------------------------------------------------------------------------------------------------------------

/// A ray through `target` from `distance` away, with a direction of any common length.
core::Ray ray_through(const dvec3& target, const dvec3& direction, double distance, Random& random) {
  return {target - distance * direction, random.log_uniform(-1.0, 1.0) * direction};
}

/// Half the extent of the primitive's bounds.
dvec3 half_extent(const Primitive& primitive) {
  const core::AabbD box = core::bounds(primitive, {});
  return 0.5 * (box.max - box.min);
}

/// A point slightly below or above the surface.
dvec3 target_near(const Primitive& primitive, double radius, Random& random) {
  const SurfacePoint p = surface_point(primitive, random);
  const dvec3 half = half_extent(primitive);
  const double thickness = std::min({radius, half.x, half.y, half.z});
  return p.point + thickness * random.uniform(-1.0, 0.1) * p.normal;
}

/// Any direction; one in four takes as long a way through the solid as its shape allows.
dvec3 direction_through(const Primitive& primitive, Random& random) {
  const dvec3 direction = random.direction();
  return random.below(4) ? direction : glm::normalize(half_extent(primitive) * direction);
}

Sample aimed(const Primitive& primitive, double distance, Random& random) {
  const double radius = radius_of(primitive);
  const dvec3 target = target_near(primitive, radius, random);
  return {primitive, {}, ray_through(target, direction_through(primitive, random), distance * radius, random), radius};
}

/// The sample in world coordinates. The frame's linear part is rounded to float first.
Sample placed(Sample sample, const Affine& world_from_item) {
  Affine frame = world_from_item;
  frame.linear = dmat3(core::mat3(frame.linear));
  sample.world_from_item = frame;
  sample.ray = {core::transform_point(frame, sample.ray.origin), frame.linear * sample.ray.direction};
  return sample;
}

// --- shapes at extremes ----------------------------------------------------------------------------------------------

/// Length or thickness is `ratio` times the radius.
Primitive slender(Kind kind, double ratio, Random& random) {
  const float r = float(random.uniform(0.5, 2.0)), length = float(ratio * r);
  switch (kind) {
    case Kind::kSnout:
      return core::Snout{r, float(0.6 * r), length, 0.2f * r, 0, 0, 0, 0, 0};
    case Kind::kRectangularTorus:
      return core::RectangularTorus{r, 2 * r, length, float(random.uniform(1.0, 6.0))};
    case Kind::kSphericalDish:
      return core::SphericalDish{r, length};
    case Kind::kEllipticalDish:
      return core::EllipticalDish{r, length};
    case Kind::kBox:
      return core::Box{2 * r, 1.5f * r, length};
    case Kind::kPyramid:
      return core::Pyramid{2 * r, 1.5f * r, r, r, 0.2f * r, 0, length};
    default:
      return core::Cylinder{r, length};
  }
}

/// Two lengths with ratio 1 + `excess`.
Primitive nearly_equal(Kind kind, double excess, Random& random) {
  const float r = float(random.uniform(0.5, 2.0)), other = float(r * (1.0 + excess)), h = float(random.uniform(1, 3));
  switch (kind) {
    case Kind::kSnout:
      return core::Snout{r, other, h, float(random.uniform(-0.5, 0.5)), 0, 0.1f, 0, 0, -0.1f};
    case Kind::kRectangularTorus:
      return core::RectangularTorus{std::min(r, other), std::max(r, other), h, float(random.uniform(1.0, 6.0))};
    case Kind::kEllipticalDish:
      return core::EllipticalDish{r, other};
    case Kind::kSphericalDish:
      return core::SphericalDish{r, other};
    default:
      return core::Pyramid{r, r, other, other, 0, 0, h};
  }
}

/// A cone or pyramid with base over height `lean`, with its apex or cut in half.
Primitive pointed(Kind kind, double lean, Random& random) {
  const double height = lean < 1.0 ? random.uniform(1.0, 3.0) : 1.0 / lean;
  const double base = height * lean, part = random.below(2) ? 0.5 : 0.0;
  if (kind == Kind::kSnout)
    return core::Snout{float(base), float(part * base), float((1.0 - part) * height), 0, 0, 0, 0, 0, 0};
  return core::Pyramid{float(2 * base),
                       float(2 * base),
                       float(2 * part * base),
                       float(2 * part * base),
                       0,
                       0,
                       float((1.0 - part) * height)};
}

/// Major radius is `ratio` times the tube's; for a rectangular torus, the middle radius over half the width.
Primitive ring(Kind kind, double ratio, float angle, Random& random) {
  const double r = random.uniform(0.5, 2.0), major = ratio * r;
  if (kind == Kind::kCircularTorus) return core::CircularTorus{float(major), float(r), angle};
  return core::RectangularTorus{float(std::max(0.0, major - r)), float(major + r), float(2.0 * r), angle};
}

// --- families --------------------------------------------------------------------------------------------------------

using Cases = std::vector<Case>;

Case make_case(Kind kind, const char* family, double magnitude, double wide, double single) {
  return {kind, family, magnitude, wide_limits(wide), single_limits(kind, single), {}};
}

std::vector<double> decades(int low, int high) {
  std::vector<double> values;
  for (int e = low; e <= high; ++e) values.push_back(std::pow(10.0, e));
  return values;
}

void add_eye_distance(Cases& cases) {
  for (const Kind kind : kSolids) {
    for (const double distance : decades(0, 7)) {
      Case c = make_case(kind, "eye-distance", distance, distance, 1.0);
      c.sample = [=](Random& random) { return aimed(plain_shape(kind, random), distance, random); };
      cases.push_back(c);
    }
  }
}

void add_slenderness(Cases& cases) {
  for (const Kind kind : kSolids) {
    if (kind == Kind::kSphere || kind == Kind::kCircularTorus) continue;
    for (const double ratio : decades(-6, 6)) {
      const double large = std::max(1.0, ratio);
      Case c = make_case(kind, "slenderness", ratio, large, large);
      if (kind == Kind::kSphericalDish) allow_reach(c.wide, c.single, large);  // a ball of that size
      c.sample = [=](Random& random) {
        return aimed(slender(kind, ratio, random), random.uniform(2.0, 10.0) * std::max(1.0, ratio), random);
      };
      cases.push_back(c);
    }
  }
}

void add_offset(Cases& cases) {
  for (const Kind kind : kSolids) {
    for (double offset : decades(0, 7)) {
      Case c = make_case(kind, "offset", offset, 10.0, 1.0);
      c.sample = [=](Random& random) {
        // The eye is near the item, both far from the world's origin. The rounding of world coordinates is part of the
        // ray, so the ray is exact.
        return placed(aimed(plain_shape(kind, random), random.uniform(1.0, 10.0), random),
                      {dmat3(1.0), offset * random.direction()});
      };
      cases.push_back(c);
    }
  }
}

void add_radii_ratio(Cases& cases) {
  const std::vector<double> excesses = {-1e-1, -1e-3, -1e-5, -1e-7, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1};
  for (const Kind kind :
       {Kind::kSnout, Kind::kRectangularTorus, Kind::kSphericalDish, Kind::kEllipticalDish, Kind::kPyramid}) {
    for (const double excess : excesses) {
      Case c = make_case(kind, "radii-ratio", excess, 10.0, 4.0);
      c.sample = [=](Random& random) {
        return aimed(nearly_equal(kind, excess, random), random.uniform(1, 10), random);
      };
      cases.push_back(c);
    }
  }
}

/// Sweeps the tangent of the half-angle: 1e-6 is a needle, 1e6 is a surface pi/2 - 1e-6 from its axis.
void add_half_angle(Cases& cases) {
  for (const Kind kind : {Kind::kSnout, Kind::kPyramid}) {
    for (const double lean : decades(-6, 6)) {
      const double slimness = std::max(1.0, 3.0 / lean);
      Case c = make_case(kind, "half-angle", lean, slimness, slimness);
      c.sample = [=](Random& random) {
        return aimed(pointed(kind, lean, random), random.uniform(2.0, 10.0) * slimness, random);
      };
      cases.push_back(c);
    }
  }
}

void add_ring(Cases& cases) {
  std::vector<double> ratios = {0.5, 0.7, 0.9, 0.999999, 1.0, 1.000001, 1.1, 2.0};
  for (const double decade : decades(1, 5)) ratios.push_back(decade);
  for (const Kind kind : {Kind::kCircularTorus, Kind::kRectangularTorus}) {
    for (const double ratio : ratios) {
      Case c = make_case(kind, "ring", ratio, 1.0, 1.0);
      allow_reach(c.wide, c.single, ratio);
      c.sample = [=](Random& random) {
        const float angle = random.below(2) ? kWhole : float(random.uniform(1.0, 6.0));
        return aimed(ring(kind, ratio, angle, random), random.uniform(2.0, 10.0) * std::max(1.0, ratio), random);
      };
      cases.push_back(c);
    }
  }
}

void add_slice_angle(Cases& cases) {
  std::vector<double> angles = decades(-4, 0);
  for (const double angle : {0.5 * kPi, kPi - 1e-4, kPi, kPi + 1e-4, 1.5 * kPi, 2.0 * kPi - 1e-2, 2.0 * kPi - 1e-4})
    angles.push_back(angle);
  angles.push_back(6.283185);  // slightly below 2 pi as a float, and closed
  angles.push_back(kWhole);
  for (const Kind kind : {Kind::kCircularTorus, Kind::kRectangularTorus}) {
    for (const double angle : angles) {
      Case c = make_case(kind, "slice-angle", angle, 4.0, 4.0);
      c.sample = [=](Random& random) {
        return aimed(ring(kind, random.uniform(1.2, 4.0), float(angle), random), random.uniform(1.0, 10.0), random);
      };
      cases.push_back(c);
    }
  }
}

/// Rays tangent to the curved face within `within` radii. They are not nearly parallel to a generator, where a tangent
/// touches all of a cylinder.
void add_tangent(Cases& cases) {
  for (const Kind kind : kSolids) {
    if (kind == Kind::kBox || kind == Kind::kPyramid) continue;
    for (const double within : decades(-7, -2)) {
      Case c = make_case(kind, "tangent", within, 1.0, 1.0);
      // Target: 1e-10 r within 1e-6 r. There t changes as the square root of the offset, so it loses that much
      // precision.
      c.wide.t = std::max(1e-12, 1e-10 * std::sqrt(1e-6 / within));
      c.wide.normal = 10.0 * c.wide.t;
      // Rounding a ray's origin and direction to float already moves it by about an ulp of a radius, so t by up to
      // sqrt(2 ulp); factor 4 for solids of a few radii. Target: at most 1 % of cylinders and cones wrong within 1e-6
      // r, without a band. The tori tried here reach four times as far in radii.
      const double reach = kind == Kind::kCircularTorus || kind == Kind::kRectangularTorus ? 4.0 : 1.0;
      const double lost = 4.0 * std::sqrt(2.0 * 2.0 * kFloatStep * reach);
      c.single = {lost, 2.0 * lost, 0.0, std::min(0.5, 0.01 * reach * 1e-6 / within)};
      c.sample = [=](Random& random) {
        const Primitive primitive = plain_shape(kind, random);
        const double radius = radius_of(primitive);
        const SurfacePoint p = lateral_point(primitive, random);
        const dvec3 target = p.point + radius * random.uniform(-within, within) * p.normal;
        const double turn = random.uniform(-1.0, 1.0);  // radians from the direction of stronger curvature
        const dvec3 direction = std::cos(turn) * p.along + std::sin(turn) * glm::cross(p.normal, p.along);
        return Sample{primitive, {}, ray_through(target, direction, random.uniform(1, 10) * radius, random), radius};
      };
      cases.push_back(c);
    }
  }
}

/// Rays tilted against the axis by `tilt`; 0 is exactly parallel.
void add_parallel(Cases& cases) {
  std::vector<double> tilts = {0.0};
  for (const double tilt : decades(-15, -1)) tilts.push_back(tilt);
  for (const Kind kind : kSolids) {
    for (const double tilt : tilts) {
      // A wall met at that slant amplifies earlier losses. Below 1e-4 hardly any ray meets a wall.
      const double slant = tilt >= 1e-4 ? 1.0 / tilt : 1.0;
      Case c = make_case(kind, "parallel", tilt, 10.0, 1.0);
      c.wide.t = std::max(c.wide.t, 64.0 * kDoubleStep * slant);
      c.single.t = std::max(c.single.t, 8.0 * kFloatStep * slant);
      c.sample = [=](Random& random) {
        const Primitive primitive = plain_shape(kind, random);
        const double radius = radius_of(primitive), turn = random.uniform(0.0, 2.0 * kPi);
        const dvec3 half = half_extent(primitive);
        const core::AabbD box = core::bounds(primitive, {});
        const dvec3 target =
            0.5 * (box.min + box.max) + half * dvec3(random.uniform(-1.1, 1.1), random.uniform(-1.1, 1.1), 0.0);
        const dvec3 direction(tilt * std::cos(turn), tilt * std::sin(turn), random.sign());
        return Sample{primitive, {}, ray_through(target, direction, random.uniform(1, 10) * radius, random), radius};
      };
      cases.push_back(c);
    }
  }
}

/// A primitive that comes to a point, and the place of that point.
struct Pointed {
  Primitive primitive;
  dvec3 apex;
};
Pointed with_apex(Kind kind, Random& random) {
  const float a = float(random.uniform(0.5, 2)), b = float(random.uniform(0.5, 2)), x = float(random.uniform(-1, 1));
  switch (kind) {
    case Kind::kSnout:
      return {core::Snout{a, 0, b, x, 0, 0.1f, 0, 0, 0}, {0.5 * x, 0, 0.5 * b}};
    case Kind::kPyramid:
      return {core::Pyramid{a, b, 0, 0, x, 0, a}, {0.5 * x, 0, 0.5 * a}};
    case Kind::kCircularTorus:  // horn: the hole closes in a point; spindle: the dent above the centre
      if (random.below(2)) return {core::CircularTorus{a, a, kWhole}, dvec3(0.0)};
      return {core::CircularTorus{0.6f * a, a, kWhole},
              {0, 0, std::sqrt((double(a) - double(0.6f * a)) * (double(a) + double(0.6f * a)))}};
    case Kind::kSphericalDish:
      return {core::SphericalDish{a, b}, {0, 0, b}};
    default:
      return {core::EllipticalDish{a, b}, {0, 0, b}};
  }
}

/// Rays that pass an apex, a pole or a pinch within `within` radii.
void add_apex(Cases& cases) {
  std::vector<double> offsets = {0.0};
  for (const double offset : decades(-12, -1)) offsets.push_back(offset);
  for (const Kind kind :
       {Kind::kSnout, Kind::kPyramid, Kind::kCircularTorus, Kind::kSphericalDish, Kind::kEllipticalDish}) {
    for (const double within : offsets) {
      Case c = make_case(kind, "apex", within, 10.0, 2.0);
      c.sample = [=](Random& random) {
        const Pointed p = with_apex(kind, random);
        const double radius = radius_of(p.primitive);
        const dvec3 target = p.apex + within * radius * random.unit() * random.direction();
        return Sample{
            p.primitive, {}, ray_through(target, random.direction(), random.uniform(1, 10) * radius, random), radius};
      };
      cases.push_back(c);
    }
  }
}

/// Rays that pass a rim, a seam or an edge within `within` radii, at any angle.
void add_rim(Cases& cases) {
  for (const Kind kind : kSolids) {
    if (kind == Kind::kSphere) continue;
    for (const double within : decades(-12, -1)) {
      Case c = make_case(kind, "rim", within, 10.0, 2.0);
      c.sample = [=](Random& random) {
        const Primitive primitive = plain_shape(kind, random);
        const double radius = radius_of(primitive);
        const dvec3 target = edge_point(primitive, random).point + within * radius * random.unit() * random.direction();
        return Sample{
            primitive, {}, ray_through(target, random.direction(), random.uniform(1, 10) * radius, random), radius};
      };
      cases.push_back(c);
    }
  }
}

dmat3 turn_about(const dvec3& axis, double angle) {
  return dmat3(glm::rotate(core::dmat4(1.0), angle, glm::normalize(axis)));
}

/// Sweeps sheared and mirrored frames by the ratio of their largest to their smallest stretch.
void add_frame(Cases& cases) {
  for (const Kind kind : kSolids) {
    for (const double stretch : decades(0, 6)) {
      Case c = make_case(kind, "frame", stretch, 10.0 * stretch, stretch);
      c.sample = [=](Random& random) {
        const dmat3 first = turn_about(random.direction(), random.uniform(0, kPi));
        const dmat3 second = turn_about(random.direction(), random.uniform(0, kPi));
        const double mirror = random.sign(), middle = std::pow(stretch, -random.unit());
        const dmat3 scale = {{mirror, 0, 0}, {0, middle, 0}, {0, 0, 1.0 / stretch}};
        return placed(aimed(plain_shape(kind, random), random.uniform(1, 10), random),
                      {first * scale * second, 10.0 * random.direction()});
      };
      cases.push_back(c);
    }
  }
}

/// Frames that flatten everything into a plane (2), a line (1) or a point (0). Nothing has volume, so nothing is hit.
void add_singular(Cases& cases) {
  for (const Kind kind : kSolids) {
    for (const int rank : {0, 1, 2}) {
      Case c = make_case(kind, "singular", rank, 1.0, 1.0);
      c.sample = [=](Random& random) {
        const dvec3 a(core::vec3(random.direction())), b(core::vec3(random.direction()));
        dmat3 linear(0.0);
        if (rank >= 1) linear[random.below(3)] = a;
        if (rank == 2) linear = dmat3{a, random.below(2) ? a : dvec3(0.0), b};
        Sample sample = aimed(plain_shape(kind, random), random.uniform(1, 10), random);
        sample.world_from_item = {linear, random.direction()};
        sample.ray.origin += sample.world_from_item.origin;
        return sample;
      };
      cases.push_back(c);
    }
  }
}

}  // namespace

std::string Case::name() const {
  char text[64];
  std::snprintf(text, sizeof(text), "%s %.7g", family.c_str(), magnitude);
  return text;
}

std::vector<Case> stability_cases() {
  Cases cases;
  for (const auto add : {add_eye_distance, add_slenderness, add_offset, add_radii_ratio, add_half_angle, add_ring,
                         add_slice_angle, add_tangent, add_parallel, add_apex, add_rim, add_frame, add_singular})
    add(cases);
  return cases;
}

std::vector<std::string> stability_families() {
  std::vector<std::string> names;
  for (const Case& c : stability_cases())
    if (std::find(names.begin(), names.end(), c.family) == names.end()) names.push_back(c.family);
  return names;
}

}  // namespace sightline::bench
