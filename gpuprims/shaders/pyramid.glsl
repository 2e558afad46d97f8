// Frustum of a rectangular pyramid, in units of its largest side or height. extra = height; texels 4 and 5: (half the
// bottom's sides, half the top's), (offset x, y, -, -).
#include "search.glsl"

struct Shape {
  vec2 lean;            // of the axis, per z
  vec2 sides, widening; // half sides at the ray's origin, and their growth per z
  float low, high;      // ends in z, relative to the ray's origin
} shape;

void load_shape(uint record, float height, float shift) {
  vec4 sides = payload_floats(record, TEXELS_PER_RECORD, 4);
  vec2 offset = payload_floats(record, TEXELS_PER_RECORD, 5).xy;
  float inverse_height = height > 0.0 ? 1.0 / height : 0.0;
  shape.lean = offset * inverse_height;
  shape.widening = (sides.zw - sides.xy) * inverse_height;
  shape.sides = 0.5 * (sides.xy + sides.zw) + (sides.zw - sides.xy) * (shift * inverse_height);
  shape.low = -0.5 * height - shift;
  shape.high = 0.5 * height - shift;
}

vec3 shape_reach() {
  float height = shape.high - shape.low;
  return vec3(abs(shape.sides) + (abs(shape.widening) + abs(shape.lean)) * height, 0.5 * height);
}

// Faces: 4 + axis on the low side, 6 + axis on the high side.
void intersect_primitive(inout Search search, vec3 o, vec3 d) {
  Span span = whole_line();
  vec2 slant = max(abs(shape.lean), abs(shape.widening));
  float start = max(slant.x, slant.y) > 1.0 ? move_to_level(o, d, 4.0) : 0.0;
  vec2 u0 = o.xy - shape.lean * o.z, u1 = d.xy - shape.lean * d.z;
  vec2 w0 = shape.sides + shape.widening * o.z, w1 = shape.widening * d.z;
  for (int axis = 0; axis < 2; ++axis) {
    clip(span, w0[axis] + u0[axis], w1[axis] + u1[axis], 4 + axis);
    clip(span, w0[axis] - u0[axis], w1[axis] - u1[axis], 6 + axis);
  }
  clip(span, o.z - shape.low, d.z, kBottom);
  clip(span, shape.high - o.z, -d.z, kTop);
  offer_span(search, span, start);
}

vec3 face_normal(vec3 p, int face) {
  if (face == kBottom || face == kTop) return vec3(0.0, 0.0, face == kTop ? 1.0 : -1.0);
  int axis = (face - 4) % 2;
  float side = face >= 6 ? 1.0 : -1.0;
  vec3 normal = vec3(0.0, 0.0, -shape.widening[axis] - side * shape.lean[axis]);
  normal[axis] = side;
  return normal;
}
