#include "sightline/gpuprims/snout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "sightline/gpuprims/cylinder.h"
#include "sightline/gpuprims/local_ray.h"
#include "sightline/gpuprims/mesh_builder.h"

namespace sightline::gpuprims {
namespace {

enum Face : int { kLateral, kBottom, kTop, kBottomLevel, kTopLevel };

/// z = height + dot(tangent, xy - centre).
struct EndPlane {
  dvec2 centre, tangent;
  double height;

  double above(const dvec3& p) const { return p.z - height - glm::dot(tangent, dvec2(p) - centre); }
  double slope(const dvec3& u) const { return u.z - glm::dot(tangent, dvec2(u)); }
};

/// The snout's solid in the terms of snout.h.
struct Solid {
  dvec2 lean;       ///< of the axis, per z
  double radius;    ///< at z = 0
  double widening;  ///< of the radius, per z
  EndPlane bottom, top;
  double lowest, highest;            ///< heights that the contours reach at most
  bool bottom_limited, top_limited;  ///< an end is cut level there

  double radius_at(double z) const { return radius + widening * z; }
  dvec3 point(const dvec2& e, double z) const {
    const double r = radius_at(z);
    return {lean * z + (r > 1e-12 * radius ? r : 0.0) * e, z};  // an apex is one point, not a ring of rounding errors
  }
  dvec3 normal(const dvec3& p) const {
    const dvec2 w = dvec2(p) - lean * p.z;
    if (glm::length(w) <= 1e-12 * radius) return {0.0, 0.0, -widening};  // the apex
    return {w, -glm::dot(lean, w) - widening * radius_at(p.z)};
  }
};

/// Whether an end plane meets the cone further out than `reach` from the end's centre, on the side of `sign`, or
/// nowhere: then the level at `reach` is a face of the solid. Otherwise it only touches, and must not cut by a rounding
/// error.
bool is_limited(const Solid& solid, const EndPlane& plane, double radius, double sign, double reach) {
  const double steep = glm::length(plane.tangent), upright = 1.0 - glm::dot(plane.tangent, solid.lean);
  const bool closed = upright > std::fabs(solid.widening) * steep;
  return !closed || radius * steep / (upright - sign * solid.widening * steep) > reach * (1.0 + 1e-12);
}

/// For height > 0.
Solid make_solid(const core::Snout& s) {
  const double h = std::fabs(s.height), rb = std::fabs(s.bottom_radius), rt = std::fabs(s.top_radius);
  const dvec2 offset(s.offset_x, s.offset_y);
  const core::EndRange bottom = core::bottom_end_range(s), top = core::top_end_range(s);
  Solid solid;
  solid.lean = offset / h;
  solid.radius = 0.5 * (rb + rt);
  solid.widening = (rt - rb) / h;
  solid.bottom = {-0.5 * offset, {std::tan(double(s.bottom_shear_x)), std::tan(double(s.bottom_shear_y))}, -0.5 * h};
  solid.top = {0.5 * offset, {std::tan(double(s.top_shear_x)), std::tan(double(s.top_shear_y))}, 0.5 * h};
  solid.lowest = -0.5 * h + bottom.min;
  solid.highest = 0.5 * h + top.max;
  solid.bottom_limited = is_limited(solid, solid.bottom, rb, -1.0, -bottom.min);
  solid.top_limited = is_limited(solid, solid.top, rt, 1.0, top.max);
  return solid;
}

bool finite(const core::Snout& s) {
  const float values[] = {s.bottom_radius,  s.top_radius,     s.height,      s.offset_x,   s.offset_y,
                          s.bottom_shear_x, s.bottom_shear_y, s.top_shear_x, s.top_shear_y};
  return all_finite(values);
}

/// What a snout of height 0 shows: the larger end.
struct Disc {
  core::Cylinder cylinder;
  dvec3 centre;
};
Disc flat_disc(const core::Snout& s) {
  const float rb = std::fabs(s.bottom_radius), rt = std::fabs(s.top_radius);
  const double side = rt > rb ? 0.5 : -0.5;
  return {{std::max(rb, rt), 0.0f}, {side * s.offset_x, side * s.offset_y, 0.0}};
}

/// The part of the line within the nappe of radius >= 0.
Span nappe_span(const Solid& solid, const dvec3& o, const dvec3& u) {
  const dvec2 w0 = dvec2(o) - solid.lean * o.z, w1 = dvec2(u) - solid.lean * u.z;
  const double r0 = solid.radius_at(o.z), r1 = solid.widening * u.z;
  const double speed = glm::length(w1), distance = glm::length(w0);
  const double a = (speed - std::fabs(r1)) * (speed + std::fabs(r1));
  const double b = glm::dot(w0, w1) - r0 * r1;
  const double c = (distance - r0) * (distance + r0);
  const double reach = glm::length(r0 * w1 - r1 * w0), moment = std::fabs(cross(w0, w1));

  Span span;
  span.clear();
  if (a == 0.0 && b == 0.0) return c <= 0.0 && r0 >= 0.0 && r1 == 0.0 ? Span{} : span;  // along the axis of a cylinder
  double discriminant = (reach - moment) * (reach + moment);
  if (a < 0.0) discriminant = std::max(0.0, discriminant);  // negative by rounding only: the line crosses both nappes
  if (!(discriminant >= 0.0)) return span;
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  const double near_root = q == 0.0 ? 0.0 : c / q;

  Span result;
  if (a == 0.0) {  // parallel to a generator: one crossing, on the nappe towards which r grows
    if (b < 0.0 && r1 > 0.0) result.enter(near_root, kLateral);
    if (b > 0.0 && r1 < 0.0) result.leave(near_root, kLateral);
    return result.from_face == Span::kNoFace && result.to_face == Span::kNoFace ? span : result;
  }
  const double far_root = q / a;
  const double low = std::min(near_root, far_root), high = std::max(near_root, far_root);
  if (a > 0.0) {
    if (!(r0 - b / a * r1 >= 0.0)) return span;  // both crossings on the other nappe
    result.enter(low, kLateral);
    result.leave(high, kLateral);
  } else if (r1 > 0.0) {
    result.enter(high, kLateral);
  } else {
    result.leave(low, kLateral);
  }
  return result;
}

/// Heights at which the generator at angle direction e lies between the ends; empty where the end planes have crossed,
/// `from` still being on the bottom contour. Along a generator an end plane's equation is linear: z' (1 - m.s - k m.e)
/// = r m.e, with z' from the end's centre.
Span generator_span(const Solid& solid, const dvec2& e) {
  Span span;
  span.enter(solid.lowest, kBottomLevel);
  span.leave(solid.highest, kTopLevel);
  if (solid.widening > 0.0) span.enter(-solid.radius / solid.widening, kLateral);
  if (solid.widening < 0.0) span.leave(-solid.radius / solid.widening, kLateral);
  const dvec3 direction(solid.lean + solid.widening * e, 1.0), start(solid.radius * e, 0.0);
  const double low = span.from, high = span.to;
  span.clip(solid.bottom.above(start), solid.bottom.slope(direction), kBottom);
  span.clip(-solid.top.above(start), -solid.top.slope(direction), kTop);
  const bool crossed = span.empty();
  span.from = std::clamp(span.from, low, std::max(low, high));
  span.to = crossed ? -std::numeric_limits<double>::infinity() : std::clamp(span.to, low, std::max(low, high));
  return span;
}

/// One generator of the tessellation, or the point between two where the end planes meet (low == high).
struct Rung {
  dvec3 low, high, normal;
};

/// Where the edge between two neighbouring contour points passes through the other end plane.
dvec3 planes_meet(const Solid& solid, const dvec3& a, const dvec3& b) {
  const double fa = solid.top.above(a), fb = solid.top.above(b);
  const double part = fa != fb ? std::clamp(fa / (fa - fb), 0.0, 1.0) : 0.5;
  return a + part * (b - a);
}

/// The generators between the ends once around, and at the line where the end planes meet, should they meet in the
/// cone.
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
    const auto point = [&](int at, double z) { return solid.point(circle[at % segments], z); };
    if (!here.empty()) rungs.push_back({point(i, here.from), point(i, here.to), normal_at(i)});
    if (here.empty() != next.empty()) {
      const dvec3 meet = planes_meet(solid, point(i, here.from), point(i + 1, next.from));
      rungs.push_back({meet, meet, normal_at(here.empty() ? i + 1 : i)});
    }
  }
  return rungs;
}

}  // namespace

template <class Real>
Hits intersect(const core::Snout& snout, const Ray& ray, Caps caps) {
  Hits hits;
  if (!finite(snout) || (snout.bottom_radius == 0.0f && snout.top_radius == 0.0f)) return hits;
  if (snout.height == 0.0f) {
    const Disc disc = flat_disc(snout);
    return intersect(disc.cylinder, {ray.origin - disc.centre, ray.direction}, caps);
  }
  const LocalRay local = closest_approach(ray);
  if (!local.valid) return hits;
  const Solid solid = make_solid(snout);
  const dvec3 &o = local.origin, &u = local.direction;

  Span span = nappe_span(solid, o, u);
  span.clip(solid.bottom.above(o), solid.bottom.slope(u), kBottom);
  span.clip(-solid.top.above(o), -solid.top.slope(u), kTop);
  if (solid.bottom_limited) span.clip(o.z - solid.lowest, u.z, kBottomLevel);
  if (solid.top_limited) span.clip(solid.highest - o.z, -u.z, kTopLevel);
  if (span.empty() || !std::isfinite(span.from) || !std::isfinite(span.to)) return hits;

  const auto emit = [&](double s, int face) {
    const double t = local.t(s);
    switch (face) {
      case kBottom:
        if (caps.bottom) hits.insert({t, {solid.bottom.tangent, -1.0}});
        break;
      case kTop:
        if (caps.top) hits.insert({t, {-solid.top.tangent, 1.0}});
        break;
      case kBottomLevel:
        if (caps.bottom) hits.insert({t, {0.0, 0.0, -1.0}});
        break;
      case kTopLevel:
        if (caps.top) hits.insert({t, {0.0, 0.0, 1.0}});
        break;
      default:
        hits.insert({t, solid.normal(o + s * u)});
    }
  };
  emit(span.from, span.from_face);
  emit(span.to, span.to_face);
  return hits;
}

template Hits intersect<double>(const core::Snout&, const Ray&, Caps);
template Hits intersect<float>(const core::Snout&, const Ray&, Caps);

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
