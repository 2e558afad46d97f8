#include <cmath>

#include "sightline/gpuprims/internal/local_ray.h"
#include "sightline/gpuprims/internal/mesh_builder.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims {
namespace {

/// A frustum that is alike in x and y: |position - lean z| <= width + widening z.
struct Frustum {
  dvec2 lean, width, widening;
  double half_height;

  void clip_sides(const dvec3& o, const dvec3& u, Span& span) const {
    for (int axis = 0; axis < 2; ++axis) {
      const double value = o[axis] - lean[axis] * o.z, slope = u[axis] - lean[axis] * u.z;
      const double reach = width[axis] + widening[axis] * o.z, growth = widening[axis] * u.z;
      const bool flat = width[axis] == 0 && widening[axis] == 0;
      if (flat && slope == 0) span = Span::nothing();  // edge on
      span.clip(reach + value, growth + slope, kMinX + 2 * axis);
      span.clip(reach - value, growth - slope, kMinX + 2 * axis + 1);
    }
  }
  /// Whether any point straight above or below p is in the frustum.
  bool casts_shadow_on(const dvec3& p) const {
    Span column{-half_height, half_height};
    clip_sides({p.x, p.y, 0}, {0, 0, 1}, column);
    return !column.empty();
  }
  dvec3 normal(int face) const {
    if (face < kMinX) return {0, 0, face == kTop ? 1 : -1};
    const int axis = (face - kMinX) / 2;
    const double side = (face - kMinX) % 2 == 0 ? -1.0 : 1.0;
    dvec3 n(0, 0, -side * lean[axis] - widening[axis]);
    n[axis] = side;
    return n;
  }
};

/// The frustum as if it had that height, with lengths multiplied by `scale`.
Frustum make_frustum(const core::Pyramid& p, double height, double scale) {
  const dvec2 bottom = glm::abs(dvec2(p.bottom_x, p.bottom_y)), top = glm::abs(dvec2(p.top_x, p.top_y));
  return {dvec2(p.offset_x, p.offset_y) / height, 0.25 * scale * (bottom + top), 0.5 * (top - bottom) / height,
          0.5 * scale * height};
}

dvec3 half_extents(const core::Pyramid& p) {
  const double x = std::max(std::fabs(p.bottom_x), std::fabs(p.top_x)) + std::fabs(double(p.offset_x));
  const double y = std::max(std::fabs(p.bottom_y), std::fabs(p.top_y)) + std::fabs(double(p.offset_y));
  return 0.5 * dvec3(x, y, std::fabs(p.height));
}

}  // namespace

Hits intersect(const core::Pyramid& pyramid, const Ray& ray, Caps caps) {
  Hits hits;
  const dvec3 half = half_extents(pyramid);
  const double size = std::max(half.x, std::max(half.y, half.z));
  if (!(size > 0.0 && std::isfinite(half.x + half.y + half.z))) return hits;
  const auto local = closest_approach(ray, weights(half), size);
  if (!local.valid) return hits;

  const bool flat = half.z == 0.0;
  const auto frustum = make_frustum(pyramid, flat ? size : 2.0 * half.z, inverse_power_of_two(size));
  Span span;
  span.clip_slab(local.origin.z, local.direction.z, flat ? 0 : frustum.half_height, kBottom, kTop);
  if (!flat) {
    frustum.clip_sides(local.origin, local.direction, span);
  } else if (span.empty() || !frustum.casts_shadow_on(local.at(span.from))) {
    return hits;
  }
  add_hits(hits, local, span, internal_faces(caps), [&](int face, const dvec3& /*p*/) { return frustum.normal(face); });
  return hits;
}

core::Mesh tessellate(const core::Pyramid& p, const Tessellation& /*config*/, Caps caps) {
  const float values[] = {p.bottom_x, p.bottom_y, p.top_x, p.top_y, p.offset_x, p.offset_y, p.height};
  if (!all_finite(values)) return {};
  const dvec3 end = 0.5 * dvec3(p.offset_x, p.offset_y, std::fabs(p.height));
  const auto rectangle = [](const dvec3& centre, double size_x, double size_y, dvec3 corners[4]) {
    const double x = 0.5 * std::fabs(size_x), y = 0.5 * std::fabs(size_y);
    const dvec2 signs[] = {{-x, -y}, {x, -y}, {x, y}, {-x, y}};
    for (int i = 0; i < 4; ++i) corners[i] = centre + dvec3(signs[i], 0.0);
  };
  dvec3 bottom[4], top[4];
  rectangle(-end, p.bottom_x, p.bottom_y, bottom);
  rectangle(end, p.top_x, p.top_y, top);

  MeshBuilder builder;
  for (int i = 0; i < 4; ++i) {
    const int next = (i + 1) % 4;
    builder.add_flat_quad(bottom[i], bottom[next], top[next], top[i]);
  }
  if (caps.top) builder.add_flat_polygon(top, {0.0, 0.0, 1.0});
  if (caps.bottom) {
    const dvec3 from_below[] = {bottom[3], bottom[2], bottom[1], bottom[0]};
    builder.add_flat_polygon(from_below, {0.0, 0.0, -1.0});
  }
  return builder.finish();
}

}  // namespace sightline::gpuprims
