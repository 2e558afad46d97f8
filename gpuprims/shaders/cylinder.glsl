// Cylinder in units of its radius: x^2 + y^2 <= 1, |z| <= h / 2, extra = h. Derivation: gpuprims/internal/cylinder.h.
#include "cylinder_span.glsl"

struct Shape {
  float low, high;  // z of the ends, relative to the ray's shifted origin
} shape;

void load_shape(uint record, float height, float shift) { shape = Shape(-0.5 * height - shift, 0.5 * height - shift); }

vec3 shape_reach() { return vec3(1.0, 1.0, 0.5 * (shape.high - shape.low)); }

void intersect_primitive(inout Search search, vec3 o, vec3 d) {
  Span span = whole_line();
  if (!cylinder_span(o, d, 1.0, kSide, span)) return;
  clip(span, o.z - shape.low + internal_cap_overlap(search, kBottom), d.z, kBottom);
  clip(span, shape.high - o.z + internal_cap_overlap(search, kTop), -d.z, kTop);
  offer_span(search, span);
}

vec3 face_normal(vec3 p, int face) {
  return face == kSide ? vec3(p.xy, 0.0) : vec3(0.0, 0.0, face == kBottom ? -1.0 : 1.0);
}
