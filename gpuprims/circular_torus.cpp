#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "sightline/gpuprims/internal/mesh_builder.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/gpuprims/internal/wedge.h"

namespace sightline::gpuprims {
namespace {

constexpr double kPi = std::numbers::pi;

/// The whole torus and a ray o + s u, in the units of the local ray. o is the point closest to the centre (o.u = 0, |u|
/// = 1).
struct Tube {
  dvec3 o, u;
  double major, tube_radius;
  double inner, outer;  // major - tube_radius and their sum

  /// g is G of the header; slope is its derivative along the ray times rho, which saves a division.
  struct Value {
    double g, slope, rho;
  };
  Value distance(double s) const {
    const double x = o.x + s * u.x, y = o.y + s * u.y, z = o.z + s * u.z;
    const double rho = std::sqrt(x * x + y * y), off = rho - major;
    return {(rho - outer) * (rho - inner) + z * z, 2 * (rho * z * u.z + off * (x * u.x + y * u.y)), rho};
  }
};

/// The cube root of x >= 0, within 1e-9 of it: Halley's method from a third of the exponent. The same steps serve
/// vectors of rays.
inline double cube_root(double x) {
  if (x == 0.0) return x;
  double y = std::bit_cast<double>((((std::bit_cast<std::uint64_t>(x) >> 32) * 0x55555556u >> 32) + 715094163u) << 32);
  for (int i = 0; i < 2; ++i) {
    const double cube = y * y * y;
    y *= (cube + 2.0 * x) / (2.0 * cube + x);
  }
  return y;
}

/// Newton step on t^3 + p t + q.
double polish_cubic(double t, double p, double q) {
  const double derivative = 3 * t * t + p;
  return derivative != 0 ? t - ((t * t + p) * t + q) / derivative : t;
}

/// Finds the real roots of t^3 + p t + q in rising order; returns their number, 1 or 3. Press et al., "Numerical
/// Recipes", section 5.6. cos(acos(x) / 3) for 0 <= x <= 1 is the root c of 4 c^3 - 3 c = x. Newton finds it from a
/// parabola within 4e-4 of it. The other two roots follow from the largest.
int depressed_cubic(double p, double q, double roots[3]) {
  const double third = -p / 3, discriminant = q * q / 4 - third * third * third;
  if (discriminant > 0 || !(p < 0)) {
    const double a = -std::copysign(cube_root(std::fabs(q) / 2 + std::sqrt(std::max(0.0, discriminant))), q);
    roots[0] = polish_cubic(a != 0 ? a + third / a : 0.0, p, q);
    return 1;
  }
  const double half = std::sqrt(third), x = std::min(1.0, std::fabs(q) / (2 * third * half));
  double c = 0.8664 + x * (0.1598 - 0.0265 * x);
  for (int i = 0; i < 2; ++i) c -= ((4 * c * c - 3) * c - x) / (12 * c * c - 3);
  const double largest = -std::copysign(2 * half * c, q),
               apart = half * std::sqrt(std::max(0.0, 3 * (1 - c) * (1 + c)));
  const double low = -largest / 2 - apart, high = -largest / 2 + apart;
  roots[0] = std::signbit(q) ? low : largest;
  roots[1] = std::signbit(q) ? high : low;
  roots[2] = std::signbit(q) ? largest : high;
  return 3;
}

/// Estimates where F crosses 0 between its extreme at e, where it is `depth` < 0, and `bound`. Newton on F's expansion
/// about e, depth + 2 (3 e^2 + p) h^2 + 4 e h^3 + h^4, in which nothing cancels. Close, not exact.
double guess_root(double depth, double e, double p, double bound) {
  const double curvature = 2 * (3 * e * e + p), reach = bound - e;
  double h = std::copysign(std::min(std::sqrt(-depth / curvature), std::fabs(reach)), reach);
  for (int i = 0; i < 4; ++i) {
    const double value = depth + h * h * (curvature + h * (4 * e + h));
    const double step = value / (h * (2 * curvature + h * (12 * e + 4 * h)));
    h -= step;
    if (!(std::fabs(step) > 1e-4 * std::fabs(h))) break;
  }
  return e + h;
}

/// Finds the crossing between `low` and `high`, where G has different signs, by safeguarded Newton from a guess.
double bracketed_root(const Tube& tube, double low, double high, bool outside_at_low, double guess) {
  // Newton squares the error, relative to the chord, or to the distance from the axis where that is less, since the
  // axis bends G. Once the square of a step is this small, another step changes nothing.
  const double least = std::numeric_limits<double>::epsilon(), chord = high - low, near = least * 0.01 * chord;
  double s = guess > low && guess < high ? guess : (low + high) / 2;
  for (int i = 0; i < 100; ++i) {
    const auto value = tube.distance(s);
    ((value.g > 0) == outside_at_low ? low : high) = s;
    double next = s - value.g * value.rho / value.slope;
    const bool newton = next >= low && next <= high;
    if (!newton) next = (low + high) / 2;
    const double step = std::fabs(next - s);
    s = next;
    if (newton ? step * step <= near * std::min(chord, value.rho) : step <= least) break;
  }
  return s;
}

/// The extremes of F, and the ends of the line in the bounding sphere on both sides: 3 to 5 values.
struct Pieces {
  double breaks[5];
  int count = 0;
  double p;  ///< of F' = 4 (s^3 + p s + q)
};
Pieces monotone_pieces(const Tube& tube, double end) {
  const double r2 = tube.major * tube.major,
               k = glm::dot(tube.o, tube.o) + (tube.major - tube.tube_radius) * (tube.major + tube.tube_radius);
  const double across = tube.u.x * tube.u.x + tube.u.y * tube.u.y, along = tube.o.x * tube.u.x + tube.o.y * tube.u.y;
  Pieces pieces;
  pieces.p = k - 2 * r2 * across;
  double extremes[3];
  const int extreme_count = depressed_cubic(pieces.p, -2 * r2 * along, extremes);
  pieces.breaks[pieces.count++] = -end;
  for (int i = 0; i < extreme_count; ++i)
    if (extremes[i] > pieces.breaks[pieces.count - 1] && extremes[i] < end) pieces.breaks[pieces.count++] = extremes[i];
  pieces.breaks[pieces.count++] = end;
  return pieces;
}

/// Where the line enters and leaves the whole torus, in rising order: 0, 2 or 4 values.
int tube_crossings(const Tube& tube, double crossings[4]) {
  const double size = tube.major + tube.tube_radius, room = size * size - glm::dot(tube.o, tube.o);
  if (!(room > -4 * std::numeric_limits<double>::epsilon() * size * size)) return 0;
  const double end = std::sqrt(std::max(0.0, room) + size * size / 1024);  // surely outside
  const Pieces pieces = monotone_pieces(tube, end);

  int count = 0;
  double depth = 0;  // F at the last break
  bool outside = true;
  for (int i = 1; i < pieces.count; ++i) {
    const double low = pieces.breaks[i - 1], high = pieces.breaks[i];
    const bool last = i + 1 == pieces.count;
    const auto value = last ? Tube::Value{1, 0, 0} : tube.distance(high);
    const double next_depth = value.g * (value.g + 4 * tube.major * value.rho);
    const bool next_outside = value.g > 0;
    if (next_outside != outside) {
      const double guess =
          outside ? guess_root(next_depth, high, pieces.p, low) : guess_root(depth, low, pieces.p, high);
      crossings[count++] = bracketed_root(tube, low, high, outside, guess);
    }
    outside = next_outside;
    depth = next_depth;
  }
  return count;
}

/// A point (rho, z) of the swept outline and its outward normal.
struct ProfilePoint {
  dvec2 position, normal;
};

/// The outline, counter-clockwise: the whole circle with its first point repeated, or the part away from the axis for a
/// spindle.
std::vector<ProfilePoint> make_profile(const Tessellation& config, double major, double tube_radius) {
  const bool spindle = major < tube_radius;
  const double half_arc = spindle ? std::acos(-major / tube_radius) : kPi;
  const int segments = std::max(spindle ? 2 : 3, segment_count(config, tube_radius, 2.0 * half_arc));
  std::vector<ProfilePoint> profile(static_cast<std::size_t>(segments) + 1);
  const std::vector<dvec2> circle = arc_points(segments, 2.0 * half_arc);
  for (int i = 0; i <= segments; ++i) {
    dvec2 e = circle[i];
    if (spindle) {
      const double angle = -half_arc + 2.0 * half_arc * i / segments;
      e = {std::cos(angle), std::sin(angle)};
    }
    profile[i] = {{std::max(0.0, major + tube_radius * e.x), tube_radius * e.y}, e};
  }
  if (spindle) profile.front().position.x = profile.back().position.x = 0.0;
  return profile;
}

}  // namespace

Hits intersect(const core::CircularTorus& torus, const Ray& ray, Caps caps) {
  Hits hits;
  const double major = std::fabs(torus.major_radius), tube_radius = std::fabs(torus.tube_radius);
  const double angle = core::sweep_angle(torus.angle), size = major + tube_radius;
  if (!(tube_radius > 0.0 && std::isfinite(size) && std::isfinite(torus.angle))) return hits;
  LocalRay local = closest_approach(ray, dvec3(1.0), size);
  if (!local.valid) return hits;
  recentre(local);
  const double per_unit = inverse_power_of_two(size);
  const Tube tube{
      local.origin,   local.direction, major * per_unit, tube_radius * per_unit, (major - tube_radius) * per_unit,
      size * per_unit};

  double crossings[4];
  const int crossing_count = tube_crossings(tube, crossings);
  if (crossing_count == 0) return hits;
  const Wedge wedge(angle);
  const auto normal = [&](int face, const dvec3& p) {
    if (face != kSide) return wedge.normal(face);
    const double rho = std::sqrt(p.x * p.x + p.y * p.y), factor = rho > 0 ? (rho - tube.major) / rho : 0;
    return dvec3(factor * p.x, factor * p.y, p.z);
  };
  for (int i = 0; i < crossing_count; i += 2) {
    Span pieces[2];
    const int count = wedge.cut(tube.o, tube.u, {crossings[i], crossings[i + 1], kSide, kSide}, pieces);
    for (int j = 0; j < count; ++j) add_hits(hits, local, pieces[j], internal_faces(caps), normal);
  }
  return hits;
}

core::Mesh tessellate(const core::CircularTorus& torus, const Tessellation& config, Caps caps) {
  const double major = std::fabs(torus.major_radius), tube_radius = std::fabs(torus.tube_radius);
  const double angle = core::sweep_angle(torus.angle), size = major + tube_radius;
  if (!(tube_radius > 0.0 && std::isfinite(size) && std::isfinite(torus.angle))) return {};
  const int columns = segment_count(config, size, angle);
  const std::vector<dvec2> sweep = arc_points(columns, angle);
  const std::vector<ProfilePoint> profile = make_profile(config, major, tube_radius);

  MeshBuilder builder;
  builder.add_grid(static_cast<int>(profile.size()) - 1, columns, [&](int row, int column) {
    const ProfilePoint& p = profile[row];
    return Vertex{dvec3(p.position.x * sweep[column], p.position.y), dvec3(p.normal.x * sweep[column], p.normal.y)};
  });
  if (angle == core::kFullTurn) return builder.finish();

  std::vector<dvec3> outline;
  outline.reserve(profile.size());
  for (const ProfilePoint& p : profile) outline.emplace_back(p.position.x * sweep.front(), p.position.y);
  if (outline.front() == outline.back()) outline.pop_back();
  // Seen along the sweep, rho points right and z up at the start: the outline is counter-clockwise as it is. The end is
  // seen from behind, so its outline is reversed.
  if (caps.bottom) builder.add_flat_polygon(outline, {0.0, -1.0, 0.0});
  outline.clear();
  for (std::size_t i = profile.size(); i-- > 0;)
    outline.emplace_back(profile[i].position.x * sweep.back(), profile[i].position.y);
  if (outline.front() == outline.back()) outline.pop_back();
  if (caps.top) builder.add_flat_polygon(outline, {-std::sin(angle), std::cos(angle), 0.0});
  return builder.finish();
}

}  // namespace sightline::gpuprims
