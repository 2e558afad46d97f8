#include <algorithm>
#include <cmath>
#include <vector>

#include "sightline/gpuprims/internal/mesh_builder.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/gpuprims/internal/wedge.h"

namespace sightline::gpuprims {
Hits intersect(const core::RectangularTorus& torus, const Ray& ray, Caps caps) {
  Hits hits;
  const double radius_a = std::fabs(torus.inner_radius), radius_b = std::fabs(torus.outer_radius);
  const double inner = std::min(radius_a, radius_b), outer = std::max(radius_a, radius_b);
  const double half = 0.5 * std::fabs(torus.height), angle = core::sweep_angle(torus.angle);
  if (!(outer > 0.0 && std::isfinite(outer + half) && std::isfinite(torus.angle))) return hits;
  const auto local = closest_approach(ray, {1.0, 1.0, weight(outer, half)}, outer);
  if (!local.valid) return hits;

  const dvec3 &o = local.origin, &u = local.direction;
  const double scale = inverse_power_of_two(outer);
  Span disc = cylinder_span(o, u, scale * outer, kSide);
  disc.clip_slab(o.z, u.z, scale * half, kBelow, kAbove);
  if (disc.empty()) return hits;
  const auto hole = inner > 0.0 ? cylinder_span(o, u, scale * inner, kInner) : Span::nothing();
  Span rings[2], pieces[2];
  const int ring_count = subtract(disc, hole, rings);
  const Wedge wedge(angle);
  const auto normal = [&](int face, const dvec3& p) -> dvec3 {
    if (face == kBottom || face == kTop) return wedge.normal(face);
    if (face == kBelow || face == kAbove) return {0, 0, face == kAbove ? 1 : -1};
    return face == kInner ? dvec3(-p.x, -p.y, 0) : dvec3(p.x, p.y, 0);
  };
  for (int i = 0; i < ring_count; ++i) {
    const int count = wedge.cut(o, u, rings[i], pieces);
    for (int j = 0; j < count; ++j) add_hits(hits, local, pieces[j], internal_faces(caps), normal);
  }
  return hits;
}

core::Mesh tessellate(const core::RectangularTorus& torus, const Tessellation& config, Caps caps) {
  const double radius_a = std::fabs(torus.inner_radius), radius_b = std::fabs(torus.outer_radius);
  const double inner = std::min(radius_a, radius_b), outer = std::max(radius_a, radius_b);
  const double half = 0.5 * std::fabs(torus.height), angle = core::sweep_angle(torus.angle);
  if (!(outer > 0.0 && std::isfinite(outer + half) && std::isfinite(torus.angle))) return {};
  const int columns = segment_count(config, outer, angle);
  const std::vector<dvec2> sweep = arc_points(columns, angle);

  struct Side {
    dvec2 from, to, normal;  // (rho, z), counter-clockwise around the rectangle
  };
  const Side sides[] = {{{outer, -half}, {outer, half}, {1.0, 0.0}},
                        {{outer, half}, {inner, half}, {0.0, 1.0}},
                        {{inner, half}, {inner, -half}, {-1.0, 0.0}},
                        {{inner, -half}, {outer, -half}, {0.0, -1.0}}};
  MeshBuilder builder;
  const auto swept = [](const dvec2& p, const dvec2& e) { return dvec3(p.x * e, p.y); };
  for (const Side& side : sides)
    builder.add_grid(1, columns, [&](int row, int column) {
      return Vertex{swept(row == 0 ? side.from : side.to, sweep[column]), swept(side.normal, sweep[column])};
    });
  if (angle == core::kFullTurn) return builder.finish();

  dvec3 start[4], end[4];
  for (int i = 0; i < 4; ++i) {
    start[i] = swept(sides[i].from, sweep.front());
    end[3 - i] = swept(sides[i].from, sweep.back());
  }
  if (caps.bottom) builder.add_flat_polygon(start, {0.0, -1.0, 0.0});
  if (caps.top) builder.add_flat_polygon(end, {-std::sin(angle), std::cos(angle), 0.0});
  return builder.finish();
}

}  // namespace sightline::gpuprims
