// Ray-casts one primitive inside its proxy.
#include "view.glsl"
#include "payload.glsl"
#include "primitive.glsl"
#include "kept_ray.glsl"
#include "shading.glsl"

flat in vec4 local_from_eye[3];
flat in uvec4 anchor;

layout(depth_less) out float gl_FragDepth;

void main() {
  uint record = anchor.z;
  uvec4 words = payload_texel(record, kTexelsPerItem, 3);  // chunk, item id, material and flags, first shape parameter
  if (dithered_away(words.z, words.y)) discard;
  float anchor_depth = uintBitsToFloat(anchor.x), shift = uintBitsToFloat(anchor.y);
  vec2 from_anchor = gl_FragCoord.xy - vec2(anchor.w & 0xffffu, anchor.w >> 16);
  mat3 rows = mat3(local_from_eye[0].xyz, local_from_eye[1].xyz, local_from_eye[2].xyz);
  vec3 direction = eye_direction(gl_FragCoord.xy);
  vec3 d = direction * rows;
  vec3 o = vec3(local_from_eye[0].w, local_from_eye[1].w, local_from_eye[2].w) + eye_step(from_anchor, anchor_depth) * rows;
  // From the ray's closest approach on, coordinates are of the primitive's own size.
  float start = -dot(o, d) / dot(d, d);
  o += start * d;
  start += anchor_depth;

  vec3 start_eye = eye_point(gl_FragCoord.xy, start), cut_normal;
  Search search = search_kept(start_eye, direction, hidden_faces(words.z), cut_normal);
  load_shape(record, uintBitsToFloat(words.w), shift);
  intersect_primitive(search, o, d);
  if (search.t == kNoHit) discard;

  gl_FragDepth = min(depth_at(start + search.t), gl_FragCoord.z);  // keeps the promise of depth_less where rounding would break it
  vec3 normal = search.face == kCut ? cut_normal : rows * face_normal(o + search.t * d, search.face);
  write_surface(normal, direction, words.z, words.y);
}
