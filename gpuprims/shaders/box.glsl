// Box: the unit cube about the origin. The placement holds its sizes.
#include "search.glsl"

void load_shape(uint record, float unused, float shift) {}

vec3 shape_reach() { return vec3(0.5); }

// Faces: 4 + axis on the low side, 7 + axis on the high side.
void intersect_primitive(inout Search search, vec3 o, vec3 d) {
  Span span = whole_line();
  for (int axis = 0; axis < 3; ++axis) {
    clip(span, 0.5 + o[axis], d[axis], 4 + axis);
    clip(span, 0.5 - o[axis], -d[axis], 7 + axis);
  }
  offer_span(search, span);
}

vec3 face_normal(vec3 p, int face) {
  vec3 normal = vec3(0.0);
  normal[(face - 4) % 3] = face >= 7 ? 1.0 : -1.0;
  return normal;
}
