// The sweep of a torus slice: the wedge about z within half an angle of the x axis. It cuts a ray into one span or two.
#include "search.glsl"

// `half_angle`: its cosine and sine. `closed`: a full turn, which has no ends. `reach`: how far the start and the end
// of the sweep lie outside their planes. Returns the number of spans.
int wedge_spans(vec3 o, vec3 d, vec2 half_angle, bool closed, vec2 reach, out Span spans[2]) {
  spans[0] = whole_line();
  spans[1] = whole_line();
  if (closed) return 1;
  // Inner normals of the half-planes that end the sweep are (sin, cos) and (sin, -cos).
  vec2 cross_start = vec2(half_angle.y, half_angle.x), cross_end = vec2(half_angle.y, -half_angle.x);
  float start = dot(o.xy, cross_start) + reach.x, start_slope = dot(d.xy, cross_start);
  float end = dot(o.xy, cross_end) + reach.y, end_slope = dot(d.xy, cross_end);
  if (half_angle.x >= 0.0) {
    if (half_angle.y == 0.0 && d.y == 0.0) return 0;  // a disc, edge on
    clip(spans[0], start, start_slope, kBottom);
    clip(spans[0], end, end_slope, kTop);
    if (is_empty(spans[0])) return 0;
    // Rounding errors may leave a part opposite a thin wedge.
    float middle = 0.5 * (max(spans[0].from, -1e30) + min(spans[0].to, 1e30));
    return o.x + middle * d.x >= 0.0 ? 1 : 0;
  }
  // The gap is convex and open: a ray along the axis is in the wedge.
  if ((start_slope == 0.0 && start >= 0.0) || (end_slope == 0.0 && end >= 0.0)) return 1;
  Span gap = whole_line();
  clip(gap, -start, -start_slope, kBottom);
  clip(gap, -end, -end_slope, kTop);
  if (!(gap.from < gap.to)) return 1;
  int count = 0;
  if (gap.from > -kNoHit) leave(spans[count++], gap.from, gap.from_face);
  if (gap.to < kNoHit) enter(spans[count++], gap.to, gap.to_face);
  return count;
}

// Offers the parts of a span of the swept solid that lie within the wedge.
void offer_swept(inout Search search, Span span, Span wedges[2], int wedge_count) {
  for (int i = 0; i < wedge_count; ++i) offer_span(search, common_part(span, wedges[i]));
}

// Outward normals of the sweep's ends.
vec3 sweep_end_normal(vec2 half_angle, int face) { return vec3(-half_angle.y, face == kBottom ? -half_angle.x : half_angle.x, 0.0); }

// Box of all points between two distances from the axis, within the sweep: low x, low y, high x, high y.
vec4 sweep_box(vec2 half_angle, float inner, float outer) {
  float c = half_angle.x, widest = c > 0.0 ? half_angle.y * outer : outer;
  return vec4(c * (c > 0.0 ? inner : outer), -widest, outer, widest);
}
