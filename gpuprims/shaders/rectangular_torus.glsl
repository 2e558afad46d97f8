// Slice of a rectangular torus in units of its outer radius, with the sweep's bisector along x. extra = height; texel
// 4: (inner radius, 1 when closed, cosine and sine of half the angle). Derivation:
// gpuprims/internal/rectangular_torus.h.
#include "cylinder_span.glsl"
#include "wedge.glsl"

const int kInner = 4, kLow = 5, kHigh = 6;

struct Shape {
  float inner, low, high;  // ends in z, relative to the ray's origin
  bool closed;
  vec2 half_angle;
} shape;

void load_shape(uint record, float height, float shift) {
  vec4 sweep = payload_floats(record, TEXELS_PER_RECORD, 4);
  shape = Shape(sweep.x, -0.5 * height - shift, 0.5 * height - shift, sweep.y > 0.0, sweep.zw);
}

vec3 shape_reach() { return vec3(1.0, 1.0, 0.5 * (shape.high - shape.low)); }

void intersect_primitive(inout Search search, vec3 o, vec3 d) {
  Span outer = whole_line();
  if (!cylinder_span(o, d, 1.0, kSide, outer)) return;
  clip(outer, o.z - shape.low, d.z, kLow);
  clip(outer, shape.high - o.z, -d.z, kHigh);
  if (is_empty(outer)) return;
  Span wedges[2];
  int wedge_count = wedge_spans(o, d, shape.half_angle, shape.closed, vec2(0.0), wedges);
  Span hole = whole_line();
  if (!(shape.inner > 0.0) || !cylinder_span(o, d, shape.inner, kInner, hole)) {
    offer_swept(search, outer, wedges, wedge_count);
    return;
  }
  Span before = outer, after = outer;
  leave(before, hole.from, kInner);
  enter(after, hole.to, kInner);
  offer_swept(search, before, wedges, wedge_count);
  offer_swept(search, after, wedges, wedge_count);
}

vec3 face_normal(vec3 p, int face) {
  if (face == kLow || face == kHigh) return vec3(0.0, 0.0, face == kHigh ? 1.0 : -1.0);
  if (face == kBottom || face == kTop) return sweep_end_normal(shape.half_angle, face);
  return vec3(face == kInner ? -p.xy : p.xy, 0.0);
}
