// Finds the nearest crossing of every ray with its own primitive: ray i with record i.
#include "payload.glsl"
#include "primitive.glsl"

layout(local_size_x = 64) in;

struct LocalRay {
  vec4 origin;     // relative to the axis at z = w
  vec4 direction;  // w unused
};
struct Crossing {
  vec3 normal;
  float t;  // kNoHit: none
};
layout(std430, binding = 0) readonly restrict buffer Rays {
  LocalRay rays[];
};
layout(std430, binding = 1) writeonly restrict buffer Crossings {
  Crossing crossings[];
};
layout(location = 0) uniform uint count;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  vec3 o = rays[i].origin.xyz, d = rays[i].direction.xyz;
  load_shape(i, uintBitsToFloat(payload_texel(i, TEXELS_PER_RECORD, 3).w), rays[i].origin.w);
  Search search = search_all();
  intersect_primitive(search, o, d);
  bool found = search.t != kNoHit;
  crossings[i] = Crossing(found ? face_normal(o + search.t * d, search.face) : vec3(0.0), search.t);
}
