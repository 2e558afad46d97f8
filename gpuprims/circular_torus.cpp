#include "sightline/gpuprims/circular_torus.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sightline/gpuprims/local_ray.h"
#include "sightline/gpuprims/mesh_builder.h"

namespace sightline::gpuprims {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFullTurn = 2.0 * kPi;
enum Face : int { kTube, kStart, kEnd };

/// Everything divided by the bounding radius R + r, so that no power of it overflows.
struct Tube {
  dvec3 o, u;  ///< the ray: o + s u
  double major, minor;

  /// G and its derivative along the ray.
  double distance(double s, double& derivative) const {
    const double x = o.x + s * u.x, y = o.y + s * u.y, z = o.z + s * u.z;
    const double rho = std::sqrt(x * x + y * y), off = rho - major;
    derivative = 2.0 * (z * u.z + (rho > 0.0 ? off * (x * u.x + y * u.y) / rho : 0.0));
    return off * off + (z - minor) * (z + minor);
  }
};

/// Newton steps on t^3 + p t + q that make the residual smaller.
double polish_cubic(double t, double p, double q) {
  double residual = (t * t + p) * t + q;
  for (int i = 0; i < 2; ++i) {
    const double derivative = 3.0 * t * t + p;
    const double next = t - residual / derivative;
    const double next_residual = (next * next + p) * next + q;
    if (!(std::fabs(next_residual) < std::fabs(residual))) break;
    t = next;
    residual = next_residual;
  }
  return t;
}

/// Real roots of t^3 + p t + q in rising order; returns their number, 1 or 3. Press et al., "Numerical Recipes",
/// section 5.6.
int depressed_cubic(double p, double q, double roots[3]) {
  const double discriminant = 0.25 * q * q + p * p * p / 27.0;
  if (discriminant > 0.0 || p >= 0.0) {
    const double a = -std::copysign(std::cbrt(0.5 * std::fabs(q) + std::sqrt(std::max(0.0, discriminant))), q);
    roots[0] = polish_cubic(a != 0.0 ? a - p / (3.0 * a) : 0.0, p, q);
    return 1;
  }
  const double m = 2.0 * std::sqrt(-p / 3.0);
  const double angle = std::acos(std::clamp(3.0 * q / (p * m), -1.0, 1.0)) / 3.0;
  roots[0] = polish_cubic(m * std::cos(angle - 4.0 / 3.0 * kPi), p, q);
  roots[1] = polish_cubic(m * std::cos(angle - 2.0 / 3.0 * kPi), p, q);
  roots[2] = polish_cubic(m * std::cos(angle), p, q);
  return 3;
}

/// The crossing between `low` and `high`, at which G has different signs.
double bracketed_root(const Tube& tube, double low, double high, bool outside_at_low) {
  constexpr double kClose = 1e-15;
  double s = 0.5 * (low + high), derivative = 0.0;
  for (int i = 0; i < 100; ++i) {
    const double value = tube.distance(s, derivative);
    ((value > 0.0) == outside_at_low ? low : high) = s;
    double next = s - value / derivative;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const double step = std::fabs(next - s);
    s = next;
    if (step <= kClose) break;
  }
  const double value = tube.distance(s, derivative);
  const double polished = s - value / derivative;
  return polished >= low && polished <= high ? polished : s;
}

/// Where the line enters and leaves the whole torus, in rising order: 0, 2 or 4 values.
int tube_crossings(const Tube& tube, double crossings[4]) {
  const double square = glm::dot(tube.o, tube.o);
  constexpr double kBeyond = 1.001;  // surely outside the bounding sphere of radius 1
  if (!(square < 1.0 + 1e-12)) return 0;
  const double end = std::sqrt(kBeyond - std::min(square, 1.0));
  const double r2 = tube.major * tube.major, k = square + (tube.major - tube.minor) * (tube.major + tube.minor);
  const double across = tube.u.x * tube.u.x + tube.u.y * tube.u.y, along = tube.o.x * tube.u.x + tube.o.y * tube.u.y;
  double extremes[3];
  const int extreme_count = depressed_cubic(k - 2.0 * r2 * across, -2.0 * r2 * along, extremes);

  double breaks[5] = {-end};
  int break_count = 1;
  for (int i = 0; i < extreme_count; ++i)
    if (extremes[i] > breaks[break_count - 1] && extremes[i] < end) breaks[break_count++] = extremes[i];
  breaks[break_count++] = end;

  int count = 0;
  bool outside = true;
  for (int i = 1; i < break_count; ++i) {
    double derivative = 0.0;
    const bool next_outside = i + 1 == break_count || tube.distance(breaks[i], derivative) > 0.0;
    if (next_outside != outside) crossings[count++] = bracketed_root(tube, breaks[i - 1], breaks[i], outside);
    outside = next_outside;
  }
  return count;
}

/// The wedge 0 <= phi <= angle about z as at most two spans of the ray.
int wedge_spans(const dvec3& o, const dvec3& u, double angle, Span spans[2]) {
  if (angle >= kFullTurn) return 1;
  const dvec2 start(0.0, 1.0), end(std::sin(angle), -std::cos(angle));  // inner normals of the two half-planes
  const double start_value = glm::dot(start, dvec2(o)), start_slope = glm::dot(start, dvec2(u));
  const double end_value = glm::dot(end, dvec2(o)), end_slope = glm::dot(end, dvec2(u));
  if (angle <= kPi) {
    if (angle == 0.0 && start_slope == 0.0) return 0;  // a disc, edge on
    spans[0].clip(start_value, start_slope, kStart);
    spans[0].clip(end_value, end_slope, kEnd);
    return spans[0].empty() ? 0 : 1;
  }
  // What is left out is convex, and open: a ray along the axis is in the wedge.
  if ((start_slope == 0.0 && start_value >= 0.0) || (end_slope == 0.0 && end_value >= 0.0)) return 1;
  Span gap;
  gap.clip(-start_value, -start_slope, kStart);
  gap.clip(-end_value, -end_slope, kEnd);
  if (!(gap.from < gap.to)) return 1;
  int count = 0;
  if (gap.from_face != Span::kNoFace) spans[count++].leave(gap.from, gap.from_face);
  if (gap.to_face != Span::kNoFace) spans[count++].enter(gap.to, gap.to_face);
  return count;
}

/// The common part of a tube span and a wedge span.
Span intersect_spans(Span a, const Span& b) {
  a.enter(b.from, b.from_face);
  a.leave(b.to, b.to_face);
  return a;
}

/// One (rho, z) point of the swept outline and its outward normal.
struct ProfilePoint {
  dvec2 position, normal;
};

/// The outline counter-clockwise: the whole circle, first point repeated, or for a spindle the part away from the axis.
std::vector<ProfilePoint> make_profile(const Tessellation& config, double major, double minor) {
  const bool spindle = major < minor;
  const double half_arc = spindle ? std::acos(-major / minor) : kPi;
  const int segments = std::max(spindle ? 2 : 3, segment_count(config, minor, 2.0 * half_arc));
  std::vector<ProfilePoint> profile(static_cast<std::size_t>(segments) + 1);
  const std::vector<dvec2> circle = arc_points(segments, 2.0 * half_arc);
  for (int i = 0; i <= segments; ++i) {
    dvec2 e = circle[i];
    if (spindle) {
      const double angle = -half_arc + 2.0 * half_arc * i / segments;
      e = {std::cos(angle), std::sin(angle)};
    }
    profile[i] = {{std::max(0.0, major + minor * e.x), minor * e.y}, e};
  }
  if (spindle) profile.front().position.x = profile.back().position.x = 0.0;
  return profile;
}

}  // namespace

template <class Real>
Hits intersect(const core::CircularTorus& torus, const Ray& ray, Caps caps) {
  Hits hits;
  const double major = std::fabs(torus.major_radius), minor = std::fabs(torus.tube_radius);
  const double angle = std::fabs(torus.angle), size = major + minor;
  if (!(minor > 0.0 && std::isfinite(size) && std::isfinite(angle))) return hits;
  const LocalRay local = closest_approach(ray);
  if (!local.valid) return hits;
  // Once more about the closest point: from a far origin the first move is off by a rounding of the distance.
  const dvec3 near_origin = local.origin / size;
  const double shift = -glm::dot(near_origin, local.direction);
  const Tube tube{near_origin + shift * local.direction, local.direction, major / size, minor / size};

  double crossings[4];
  const int crossing_count = tube_crossings(tube, crossings);
  if (crossing_count == 0) return hits;
  Span wedges[2];
  const int wedge_count = wedge_spans(tube.o, tube.u, angle, wedges);
  const dvec2 bisector(std::cos(0.5 * std::min(angle, kPi)), std::sin(0.5 * std::min(angle, kPi)));

  const auto emit = [&](double s, int face) {
    const double t = local.t((s + shift) * size);
    if (face == kStart) {
      if (caps.bottom) hits.insert({t, {0.0, -1.0, 0.0}});
    } else if (face == kEnd) {
      if (caps.top) hits.insert({t, {-std::sin(angle), std::cos(angle), 0.0}});
    } else {
      const dvec3 p = tube.o + s * tube.u;
      const double rho = glm::length(dvec2(p)), factor = rho > 0.0 ? (rho - tube.major) / rho : 0.0;
      hits.insert({t, {factor * p.x, factor * p.y, p.z}});
    }
  };
  for (int i = 0; i + 1 < crossing_count; i += 2) {
    Span inside;
    inside.enter(crossings[i], kTube);
    inside.leave(crossings[i + 1], kTube);
    for (int j = 0; j < wedge_count; ++j) {
      const Span span = intersect_spans(inside, wedges[j]);
      if (span.empty()) continue;
      const dvec2 middle = dvec2(tube.o) + 0.5 * (span.from + span.to) * dvec2(tube.u);
      if (angle <= kPi && glm::dot(middle, bisector) < 0.0) continue;  // rounding errors opposite a thin wedge
      emit(span.from, span.from_face);
      emit(span.to, span.to_face);
    }
  }
  return hits;
}

template Hits intersect<double>(const core::CircularTorus&, const Ray&, Caps);
template Hits intersect<float>(const core::CircularTorus&, const Ray&, Caps);

core::Mesh tessellate(const core::CircularTorus& torus, const Tessellation& config, Caps caps) {
  const double major = std::fabs(torus.major_radius), minor = std::fabs(torus.tube_radius);
  const double angle = std::fabs(torus.angle), size = major + minor;
  if (!(minor > 0.0 && std::isfinite(size) && std::isfinite(angle))) return {};
  const int columns = segment_count(config, size, std::min(angle, kFullTurn));
  const std::vector<dvec2> sweep = arc_points(columns, angle);
  const std::vector<ProfilePoint> profile = make_profile(config, major, minor);

  MeshBuilder builder;
  builder.add_grid(static_cast<int>(profile.size()) - 1, columns, [&](int row, int column) {
    const ProfilePoint& p = profile[row];
    return Vertex{dvec3(p.position.x * sweep[column], p.position.y), dvec3(p.normal.x * sweep[column], p.normal.y)};
  });
  if (angle >= kFullTurn) return builder.finish();

  std::vector<dvec3> outline;
  outline.reserve(profile.size());
  for (const ProfilePoint& p : profile) outline.emplace_back(p.position.x * sweep.front(), p.position.y);
  if (outline.front() == outline.back()) outline.pop_back();
  // Looking along the sweep onto the start, rho points right and z up: counter-clockwise as it is. The end is seen from
  // behind.
  if (caps.bottom) builder.add_flat_polygon(outline, {0.0, -1.0, 0.0});
  outline.clear();
  for (std::size_t i = profile.size(); i-- > 0;)
    outline.emplace_back(profile[i].position.x * sweep.back(), profile[i].position.y);
  if (outline.front() == outline.back()) outline.pop_back();
  if (caps.top) builder.add_flat_polygon(outline, {-std::sin(angle), std::cos(angle), 0.0});
  return builder.finish();
}

}  // namespace sightline::gpuprims
