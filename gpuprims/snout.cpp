#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "sightline/gpuprims/internal/local_ray.h"
#include "sightline/gpuprims/internal/mesh_builder.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims {
namespace {

/// The plane z = height + dot(tangent, xy - centre).
struct EndPlane {
  dvec2 centre, tangent;
  double height;

  double above(const dvec3& p) const { return p.z - height - glm::dot(tangent, dvec2(p) - centre); }
  double slope(const dvec3& u) const { return u.z - glm::dot(tangent, dvec2(u)); }

  EndPlane scaled(double scale) const { return {scale * centre, tangent, scale * height}; }
};

/// The snout's solid in the terms of snout.h.
struct Solid {
  dvec2 lean;       ///< of the axis, per z
  double radius;    ///< at z = 0
  double widening;  ///< of the radius, per z
  EndPlane bottom, top;
  double lowest, highest;            ///< bounds of the heights that the contours reach
  bool bottom_limited, top_limited;  ///< that end has a level cut
  bool slanted;                      ///< false: both end planes are level

  double radius_at(double z) const { return radius + widening * z; }
  dvec2 from_axis(const dvec3& p) const { return {p.x - lean.x * p.z, p.y - lean.y * p.z}; }
  dvec3 lateral_normal(const dvec3& p) const {
    const dvec2 w = from_axis(p);
    if (glm::dot(w, w) <= 1e-24 * radius * radius) return {0, 0, -widening};  // the apex
    return {w.x, w.y, -glm::dot(lean, w) - widening * glm::length(w)};
  }
  /// Has no branch on the face: see choose() in local_ray.h.
  dvec3 normal(int face, const dvec3& p) const {
    constexpr double kSideShare[] = {1, 0, 0, 0, 0}, kUp[] = {0, -1, 1, -1, 1};
    dvec3 n = kSideShare[face] * lateral_normal(p);
    n.z += kUp[face];
    if (slanted && face == kBottom) n += dvec3(bottom.tangent, 0);
    if (slanted && face == kTop) n -= dvec3(top.tangent, 0);
    return n;
  }
  Solid scaled(double scale) const {
    return {lean,           scale * radius,  widening,       bottom.scaled(scale), top.scaled(scale),
            scale * lowest, scale * highest, bottom_limited, top_limited,          slanted};
  }
};

/// Whether an end needs its level cut at `reach` from the end's centre: its plane meets the cone farther out than that
/// on the side of `sign`, or has no closed contour. Otherwise the level only touches the contour, and must not cut it
/// by a rounding error.
bool is_limited(const Solid& solid, const EndPlane& plane, double radius, double sign, double reach) {
  const double steep = glm::length(plane.tangent), upright = 1.0 - glm::dot(plane.tangent, solid.lean);
  const bool closed = upright > std::fabs(solid.widening) * steep;
  return !closed || radius * steep / (upright - sign * solid.widening * steep) > reach * (1.0 + 1e-12);
}

bool is_slanted(const core::Snout& s) {
  return s.bottom_shear_x != 0.0f || s.bottom_shear_y != 0.0f || s.top_shear_x != 0.0f || s.top_shear_y != 0.0f;
}

/// Both end planes are level; height > 0; lengths are multiplied by `scale`. Separate from make_solid because its
/// tangents are slow.
Solid make_level_solid(const core::Snout& s, double scale) {
  const double per_height = 1.0 / std::fabs(s.height), half = 0.5 * scale * std::fabs(s.height);
  const double rb = std::fabs(s.bottom_radius), rt = std::fabs(s.top_radius);
  const dvec2 centre(0.5 * scale * s.offset_x, 0.5 * scale * s.offset_y);
  Solid solid;
  solid.lean = {s.offset_x * per_height, s.offset_y * per_height};
  solid.radius = 0.5 * scale * (rb + rt);
  solid.widening = (rt - rb) * per_height;
  solid.highest = half;
  solid.lowest = -solid.highest;
  solid.bottom = {-centre, dvec2(0), solid.lowest};
  solid.top = {centre, dvec2(0), solid.highest};
  solid.bottom_limited = solid.top_limited = solid.slanted = false;
  return solid;
}

/// Needs height > 0.
Solid make_solid(const core::Snout& s) {
  Solid solid = make_level_solid(s, 1.0);
  solid.slanted = is_slanted(s);
  if (!solid.slanted) return solid;
  const double h = std::fabs(s.height), rb = std::fabs(s.bottom_radius), rt = std::fabs(s.top_radius);
  const core::EndRange bottom = core::bottom_end_range(s), top = core::top_end_range(s);
  solid.bottom.tangent = {std::tan(double(s.bottom_shear_x)), std::tan(double(s.bottom_shear_y))};
  solid.top.tangent = {std::tan(double(s.top_shear_x)), std::tan(double(s.top_shear_y))};
  solid.lowest = -0.5 * h + bottom.min;
  solid.highest = 0.5 * h + top.max;
  solid.bottom_limited = is_limited(solid, solid.bottom, rb, -1.0, -bottom.min);
  solid.top_limited = is_limited(solid, solid.top, rt, 1.0, top.max);
  return solid;
}

bool finite(const core::Snout& s) {
  const double lengths = double(s.bottom_radius) * 0.0 + double(s.top_radius) * 0.0 + double(s.height) * 0.0;
  const double others = double(s.offset_x) * 0.0 + double(s.offset_y) * 0.0 + double(s.bottom_shear_x) * 0.0 +
                        double(s.bottom_shear_y) * 0.0 + double(s.top_shear_x) * 0.0 + double(s.top_shear_y) * 0.0;
  return lengths + others == 0.0;  // NaN where any is not finite
}

/// Lengths are multiplied by `scale`; height > 0.
Solid make_local_solid(const core::Snout& s, double scale) {
  if (is_slanted(s)) return make_solid(s).scaled(scale);
  return make_level_solid(s, scale);
}

/// The larger end: all that a snout of height 0 shows.
struct Disc {
  core::Cylinder cylinder;
  dvec3 centre;
};
Disc flat_disc(const core::Snout& s) {
  const float rb = std::fabs(s.bottom_radius), rt = std::fabs(s.top_radius);
  const double side = rt > rb ? 0.5 : -0.5;
  return {{std::max(rb, rt), 0.0f}, {side * s.offset_x, side * s.offset_y, 0.0}};
}

/// Moves the ray to its point closest to the (leaning) axis, by the measure of local_ray.h. `reach`: extent along z.
LocalRay approach_axis(const core::Snout& s, const Ray& ray, double widest, double reach) {
  const ScaledRay scaled = scale_direction(ray);
  const dvec3 &o = scaled.origin, &d = scaled.direction;
  const double per_height = 1.0 / std::fabs(s.height), lean_x = s.offset_x * per_height,
               lean_y = s.offset_y * per_height;
  const dvec3 upright_o(o.x - lean_x * o.z, o.y - lean_y * o.z, o.z);
  const dvec3 upright_d(d.x - lean_x * d.z, d.y - lean_y * d.z, d.z);
  return move_to(scaled, closest_approach(upright_o, upright_d, {1.0, 1.0, weight(widest, reach)}), widest);
}

/// The part of the line within the nappe with radius >= 0, about its point o. There |w| and r should be as small as
/// they get: at the apex all terms vanish, and so must their errors.
Span nappe_span(const Solid& solid, const dvec3& o, const dvec3& u) {
  const dvec2 w0 = solid.from_axis(o), w1 = solid.from_axis(u);
  const double r0 = solid.radius_at(o.z), r1 = solid.widening * u.z;
  const double speed = glm::dot(w1, w1), b = glm::dot(w0, w1) - r0 * r1, c = glm::dot(w0, w0) - r0 * r0;
  const auto nothing = Span::nothing();
  // So nearly along the axis of a cylinder that the squares would underflow; see cylinder_span.
  if (!(speed + r1 * r1 > 1024 * std::numeric_limits<double>::min())) return c <= 0 && r0 >= 0 ? Span() : nothing;
  const double a = speed - r1 * r1, moment = cross(w0, w1);
  const dvec2 reach(r0 * w1.x - r1 * w0.x, r0 * w1.y - r1 * w0.y);
  double discriminant = glm::dot(reach, reach) - moment * moment;
  if (a < 0) discriminant = std::max(0.0, discriminant);  // negative by rounding only: the line crosses both nappes
  if (!(discriminant >= 0)) return nothing;
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  const double near_root = q == 0 ? 0 : c / q;

  Span span;
  if (a == 0) {  // parallel to a generator: one crossing, on the nappe towards which r grows
    if (q > 0 && r1 > 0)
      span.enter(near_root, kSide);
    else if (q < 0 && r1 < 0)
      span.leave(near_root, kSide);
    else
      return nothing;
    return span;
  }
  const double far_root = q / a, low = std::min(near_root, far_root), high = std::max(near_root, far_root);
  if (a > 0) {
    if (!(r0 * a - b * r1 >= 0)) return nothing;  // both crossings on the other nappe
    return {low, high, kSide, kSide};
  }
  const bool grows = r1 > 0;  // one crossing on each nappe: inside from or up to the one on this nappe
  span.from = grows ? high : -Span::kInfinity;
  span.to = grows ? Span::kInfinity : low;
  span.from_face = choose(grows, kSide, Span::kNoFace);
  span.to_face = choose(grows, Span::kNoFace, kSide);
  return span;
}

/// Moves the ray's origin to where |w|^2 + r^2 is least, unless that is far outside the solid, whose axis may lean far.
void approach_apex(const Solid& solid, LocalRay& ray) {
  const dvec2 w0 = solid.from_axis(ray.origin), w1 = solid.from_axis(ray.direction);
  const double r0 = solid.radius_at(ray.origin.z), r1 = solid.widening * ray.direction.z;
  const double square = glm::dot(w1, w1) + r1 * r1;
  const double shift = -(glm::dot(w0, w1) + r0 * r1) / square;
  const double most =
      4 * (1 + (solid.highest - solid.lowest) * (1 + std::fabs(solid.lean.x) + std::fabs(solid.lean.y)));
  if (!(std::fabs(shift) <= most)) return;
  ray.origin += shift * ray.direction;
  ray.start += shift * ray.scale;
}

/// Whether the whole cone lies beyond the end plane through its apex, so that nothing but the apex is left.
bool is_apex_only(const Solid& solid, const core::Snout& s) {
  const auto beyond = [&](const EndPlane& plane) {
    return 1 - glm::dot(plane.tangent, solid.lean) < -std::fabs(solid.widening) * glm::length(plane.tangent);
  };
  return (s.bottom_radius == 0.0f && beyond(solid.bottom)) || (s.top_radius == 0.0f && beyond(solid.top));
}

/// Clips a span between the ends.
void clip_ends(const Solid& solid, const dvec3& o, const dvec3& u, Span& span) {
  if (!solid.slanted) return span.clip_slab(o.z, u.z, solid.highest, kBottom, kTop);
  span.clip(solid.bottom.above(o), solid.bottom.slope(u), kBottom);
  span.clip(-solid.top.above(o), -solid.top.slope(u), kTop);
  if (solid.bottom_limited) span.clip(o.z - solid.lowest, u.z, kBottomLevel);
  if (solid.top_limited) span.clip(solid.highest - o.z, -u.z, kTopLevel);
}

/// Needs height > 0. A separate function, so that no path has hits to copy.
Hits intersect_solid(const core::Snout& snout, const Ray& ray, Caps caps) {
  Hits hits;
  const double widest = std::max(std::fabs(snout.bottom_radius), std::fabs(snout.top_radius));
  const double scale = inverse_power_of_two(widest);
  const Solid solid = make_local_solid(snout, scale);
  if (solid.slanted && is_apex_only(solid, snout)) return hits;
  const double reach = std::max(-solid.lowest, solid.highest) / scale;
  auto local = approach_axis(snout, ray, widest, reach);
  if (!local.valid) return hits;
  approach_apex(solid, local);
  Span span = nappe_span(solid, local.origin, local.direction);
  clip_ends(solid, local.origin, local.direction, span);
  const unsigned hidden = (caps.bottom ? 0u : 1u << kBottom | 1u << kBottomLevel) |  //
                          (caps.top ? 0u : 1u << kTop | 1u << kTopLevel);
  add_hits(hits, local, span, hidden, [&](int face, const dvec3& p) { return solid.normal(face, p); });
  return hits;
}

/// Range of heights where the generator in the angular direction e lies between the ends. Empty where the end planes
/// have crossed; `from` is then still on the bottom contour. Along a generator an end plane's equation is linear: z' (1
/// - m.s - k m.e) = r m.e, with z' relative to the end's centre.
Span generator_span(const Solid& solid, const dvec2& e) {
  Span span;
  span.enter(solid.lowest, kBottomLevel);
  span.leave(solid.highest, kTopLevel);
  if (solid.widening > 0.0) span.enter(-solid.radius / solid.widening, kSide);
  if (solid.widening < 0.0) span.leave(-solid.radius / solid.widening, kSide);
  const dvec3 direction(solid.lean + solid.widening * e, 1.0), start(solid.radius * e, 0.0);
  const double low = span.from, high = span.to;
  span.clip(solid.bottom.above(start), solid.bottom.slope(direction), kBottom);
  span.clip(-solid.top.above(start), -solid.top.slope(direction), kTop);
  const bool crossed = span.empty();
  span.from = std::clamp(span.from, low, std::max(low, high));
  span.to = crossed ? -std::numeric_limits<double>::infinity() : std::clamp(span.to, low, std::max(low, high));
  return span;
}

dvec3 generator_point(const Solid& solid, const dvec2& e, double z) {
  const double r = solid.radius_at(z);  // an apex is one point, not a ring of rounding errors
  return {solid.lean * z + (r > 1e-12 * solid.radius ? r : 0.0) * e, z};
}

/// One generator of the tessellation, or the point between two where the end planes meet (low == high).
struct Rung {
  dvec3 low, high, normal;
};

/// Point where the edge between two neighbouring contour points passes through the other end plane.
dvec3 planes_meet(const Solid& solid, const dvec3& a, const dvec3& b) {
  const double fa = solid.top.above(a), fb = solid.top.above(b);
  const double part = fa != fb ? std::clamp(fa / (fa - fb), 0.0, 1.0) : 0.5;
  return a + part * (b - a);
}

/// The generators between the ends once around, and the points where the end planes meet, if they meet within the cone.
std::vector<Rung> make_rungs(const Solid& solid, int segments) {
  const std::vector<dvec2> circle = arc_points(segments, 2.0 * std::numbers::pi);
  std::vector<Rung> rungs;
  const auto span_at = [&](int i) { return generator_span(solid, circle[i % segments]); };
  const auto normal_at = [&](int i) {
    const dvec2& e = circle[i % segments];
    return dvec3(e, -glm::dot(solid.lean, e) - solid.widening);
  };
  for (int i = 0; i < segments; ++i) {
    const Span here = span_at(i), next = span_at(i + 1);
    const auto point = [&](int at, double z) { return generator_point(solid, circle[at % segments], z); };
    if (!here.empty()) rungs.push_back({point(i, here.from), point(i, here.to), normal_at(i)});
    if (here.empty() != next.empty()) {
      const dvec3 meet = planes_meet(solid, point(i, here.from), point(i + 1, next.from));
      rungs.push_back({meet, meet, normal_at(here.empty() ? i + 1 : i)});
    }
  }
  return rungs;
}

}  // namespace

Hits intersect(const core::Snout& snout, const Ray& ray, Caps caps) {
  if (!finite(snout) || (snout.bottom_radius == 0.0f && snout.top_radius == 0.0f)) return {};
  if (snout.height != 0.0f) return intersect_solid(snout, ray, caps);
  const Disc disc = flat_disc(snout);
  return intersect(disc.cylinder, {ray.origin - disc.centre, ray.direction}, caps);
}

core::Mesh tessellate(const core::Snout& snout, const Tessellation& config, Caps caps) {
  if (!finite(snout) || (snout.bottom_radius == 0.0f && snout.top_radius == 0.0f)) return {};
  if (snout.height == 0.0f) {
    const Disc disc = flat_disc(snout);
    core::Mesh mesh = tessellate(disc.cylinder, config, caps);
    for (core::vec3& p : mesh.positions) p += core::vec3(disc.centre);
    return mesh;
  }
  const Solid solid = make_solid(snout);
  const double widest = std::max(solid.radius_at(solid.lowest), solid.radius_at(solid.highest));
  const std::vector<Rung> rungs = make_rungs(solid, segment_count(config, widest, 2.0 * std::numbers::pi));
  const int count = static_cast<int>(rungs.size());
  if (count < 2) return {};

  MeshBuilder builder;
  builder.add_grid(1, count, [&](int row, int column) {
    const Rung& rung = rungs[column % count];
    return Vertex{row == 0 ? rung.low : rung.high, rung.normal};
  });
  std::vector<dvec3> contour(rungs.size());
  if (caps.top) {
    for (int i = 0; i < count; ++i) contour[i] = rungs[i].high;
    builder.add_flat_polygon(contour, {-solid.top.tangent, 1.0});
  }
  if (caps.bottom) {
    for (int i = 0; i < count; ++i) contour[i] = rungs[count - 1 - i].low;
    builder.add_flat_polygon(contour, {solid.bottom.tangent, -1.0});
  }
  return builder.finish();
}

}  // namespace sightline::gpuprims
