// Ray-casts one primitive inside its proxy.
#define FRAGMENT_STAGE
#include "view.glsl"
#include "payload.glsl"
#include "ray.glsl"
#ifdef CYLINDER
#include "cylinder.glsl"
#endif
#ifdef SNOUT
#include "snout.glsl"
#endif
#ifdef CIRCULAR_TORUS
#include "circular_torus.glsl"
#endif
#ifdef SPHERE_CAP
#include "sphere_cap.glsl"
#endif
#include "shading.glsl"

flat in vec4 local_from_eye[3];
flat in uint record;

layout(depth_less) out float gl_FragDepth;

void main() {
  uvec4 words = payload_texel(record, kTexelsPerItem, 3);  // chunk, item id, material and flags, first shape parameter
  if (dithered_away(words.z, words.y)) discard;
  Search search;
  search.ray = pixel_ray(gl_FragCoord.xy);
  search.t = kNoHit;
  search.normal = vec3(0.0);
  mat3 eye_rows = mat3(local_from_eye[0].xyz, local_from_eye[1].xyz, local_from_eye[2].xyz);
  vec3 o = vec3(local_from_eye[0].w, local_from_eye[1].w, local_from_eye[2].w) + search.ray.eye_origin * eye_rows;
  vec3 d = search.ray.eye_direction * eye_rows;
  // From the ray's closest approach to the local origin on, coordinates are of the primitive's own size.
  search.t_shift = -dot(o, d) / dot(d, d);
  o += search.t_shift * d;
  intersect_primitive(search, o, d, uintBitsToFloat(words.w), record, words.z);
  if (search.t == kNoHit) discard;

  vec3 p_eye = search.ray.eye_origin + search.t * search.ray.eye_direction;
  vec4 clip_z = vec4(view.clip_from_eye[0].z, view.clip_from_eye[1].z, view.clip_from_eye[2].z, view.clip_from_eye[3].z);
  vec4 clip_w = vec4(view.clip_from_eye[0].w, view.clip_from_eye[1].w, view.clip_from_eye[2].w, view.clip_from_eye[3].w);
  float depth = dot(clip_z, vec4(p_eye, 1.0)) / dot(clip_w, vec4(p_eye, 1.0));
  gl_FragDepth = min(depth, gl_FragCoord.z);  // keeps the promise of depth_less where rounding would break it
  write_surface(eye_rows * search.normal, search.ray.eye_direction, words.z, words.y);
}
