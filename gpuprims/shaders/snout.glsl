// Snout (truncated cone, eccentric, slanted ends) in units of its larger radius. Derivation: gpuprims/internal/snout.h.
// extra = height; texels 4 to 6: (bottom radius, top radius, offset x, y), (bottom slant x, y, top slant x, y), (lowest
// and highest z of the solid, level cuts below and above or far beyond).
#include "arithmetic.glsl"
#include "search.glsl"

struct Shape {
  vec2 lean;                       // of the axis, per z
  vec2 radius;                     // at the ray's origin: float, and what it leaves
  float widening;                  // of the radius, per z
  float to_bottom, to_top;         // height of the ray's origin above the bottom, and below the top
  vec2 bottom_slant, top_slant;
  float lowest, highest;           // level cuts, relative to the ray's origin
} shape;

void load_shape(uint record, float height, float shift) {
  vec4 ends = payload_floats(record, TEXELS_PER_RECORD, 4);
  vec4 slants = payload_floats(record, TEXELS_PER_RECORD, 5);
  vec4 range = payload_floats(record, TEXELS_PER_RECORD, 6);
  float inverse_height = height > 0.0 ? 1.0 / height : 0.0;
  shape.lean = ends.zw * inverse_height;
  shape.widening = (ends.y - ends.x) * inverse_height;
  Pair3 radius = pair_sum(pair_sum(vec3(0.5 * ends.x), vec3(0.5 * ends.y)), vec3((ends.y - ends.x) * (shift * inverse_height)));
  shape.radius = vec2(radius.high.x, radius.low.x);
  shape.to_bottom = 0.5 * height + shift;
  shape.to_top = 0.5 * height - shift;
  shape.bottom_slant = slants.xy;
  shape.top_slant = slants.zw;
  shape.lowest = range.z - shift;
  shape.highest = range.w - shift;
}

vec3 shape_reach() {
  float height = shape.to_bottom + shape.to_top;
  vec2 slants = abs(shape.bottom_slant) + abs(shape.top_slant);
  return vec3(1.0 + abs(shape.lean) * height, 0.5 * height + slants.x + slants.y);
}

// |r0 u1 - r1 u0|^2 - (u0 x u1)^2 exactly, including the line's position relative to the axis.
float exact_discriminant(vec3 o, vec3 d) {
  vec3 slope = vec3(-shape.lean, shape.widening);
  Pair3 u = pair_sum(pair_product(slope, o.zzz), Pair3(vec3(o.xy, shape.radius.x), vec3(0.0, 0.0, shape.radius.y)));
  Pair3 v = pair_sum(pair_product(slope, d.zzz), vec3(d.xy, 0.0));
  return exact_cone_discriminant(u, v);
}

// The part of the line within the nappe with radius >= 0, where u = xy - centre(z) and r(z) are linear in t. False when
// there is none.
bool nappe(vec3 o, vec3 d, inout Span span) {
  vec2 u0 = o.xy - shape.lean * o.z, u1 = d.xy - shape.lean * d.z;
  float r0 = shape.radius.x + shape.widening * o.z, r1 = shape.widening * d.z;
  float across = dot(u1, u1), b = dot(u0, u1) - r0 * r1, c = dot(u0, u0) - r0 * r0;
  float a = across - r1 * r1;
  if (abs(a) < kCancels * across) a = (length(u1) - abs(r1)) * (length(u1) + abs(r1));
  if (a == 0.0 && b == 0.0) return c <= 0.0 && r0 >= 0.0 && r1 == 0.0;  // along the axis of a cylinder
  // b^2 - a c, its large equal terms cancelled by hand: |r0 u1 - r1 u0|^2 - (u0 x u1)^2.
  vec2 v = r0 * u1 - r1 * u0;
  float m = cross_product(u0, u1), square = dot(v, v), rest = square - m * m;
  if (abs(rest) < kCancels * square) rest = exact_discriminant(o, d);
  if (a < 0.0) rest = max(rest, 0.0);  // negative by rounding only: the line crosses both nappes
  if (!(rest >= 0.0)) return false;
  float root = sqrt(rest), q = b >= 0.0 ? -(b + root) : root - b;
  float near_root = q == 0.0 ? 0.0 : c / q;
  if (a == 0.0) {  // parallel to a generator: one crossing, on the nappe towards which r grows
    if (b < 0.0 && r1 > 0.0) enter(span, near_root, kSide);
    else if (b > 0.0 && r1 < 0.0) leave(span, near_root, kSide);
    else return false;
    return true;
  }
  float far_root = q / a, first = min(near_root, far_root), last = max(near_root, far_root);
  if (a > 0.0) {
    if (!(r0 - b / a * r1 >= 0.0)) return false;  // both crossings on the other nappe
    enter(span, first, kSide);
    leave(span, last, kSide);
  } else if (r1 > 0.0) {
    enter(span, last, kSide);
  } else {
    leave(span, first, kSide);
  }
  return true;
}

void intersect_primitive(inout Search search, vec3 o, vec3 d) {
  Span span = whole_line();
  bool flat_one = max(abs(shape.widening), max(abs(shape.lean.x), abs(shape.lean.y))) > 1.0;
  float start = flat_one ? move_to_level(o, d, 4.0) : 0.0;
  if (!nappe(o, d, span)) return;
  vec2 from_bottom = o.xy + shape.lean * shape.to_bottom, from_top = o.xy - shape.lean * shape.to_top;
  float reach_bottom = internal_cap_overlap(search, kBottom) * length(vec3(shape.bottom_slant, 1.0));
  float reach_top = internal_cap_overlap(search, kTop) * length(vec3(shape.top_slant, 1.0));
  clip(span, o.z + shape.to_bottom - dot(shape.bottom_slant, from_bottom) + reach_bottom, d.z - dot(shape.bottom_slant, d.xy),
       kBottom);
  clip(span, shape.to_top - o.z + dot(shape.top_slant, from_top) + reach_top, dot(shape.top_slant, d.xy) - d.z, kTop);
  clip(span, o.z - shape.lowest, d.z, kBottomLevel);
  clip(span, shape.highest - o.z, -d.z, kTopLevel);
  offer_span(search, span, start);
}

vec3 face_normal(vec3 p, int face) {
  if (face == kBottom) return vec3(shape.bottom_slant, -1.0);
  if (face == kTop) return vec3(-shape.top_slant, 1.0);
  if (face == kBottomLevel || face == kTopLevel) return vec3(0.0, 0.0, face == kTopLevel ? 1.0 : -1.0);
  vec2 u = p.xy - shape.lean * p.z;
  return vec3(u, -dot(u, shape.lean) - shape.widening * length(u));  // uses |u| instead of r, which cancels at an apex
}
