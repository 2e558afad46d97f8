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
#include "shading.glsl"

flat in mat3 local_from_eye;
flat in vec3 local_eye;
flat in uvec3 item_words;
flat in float item_extra;

layout(depth_less) out float gl_FragDepth;

void main() {
  if (dithered_away(item_words.y, item_words.x)) discard;
  Search search;
  search.ray = pixel_ray(gl_FragCoord.xy);
  search.t = kNoHit;
  search.normal = vec3(0.0);
  vec3 o = local_eye + local_from_eye * search.ray.eye_origin;
  vec3 d = local_from_eye * search.ray.eye_direction;
  // From the ray's closest approach to the local origin on, coordinates are of the primitive's own size.
  search.t_shift = -dot(o, d) / dot(d, d);
  o += search.t_shift * d;
  intersect_primitive(search, o, d, item_extra, item_words.z, item_words.y);
  if (search.t == kNoHit) discard;

  vec3 p_eye = search.ray.eye_origin + search.t * search.ray.eye_direction;
  vec4 clip_z = vec4(view.clip_from_eye[0].z, view.clip_from_eye[1].z, view.clip_from_eye[2].z, view.clip_from_eye[3].z);
  vec4 clip_w = vec4(view.clip_from_eye[0].w, view.clip_from_eye[1].w, view.clip_from_eye[2].w, view.clip_from_eye[3].w);
  float depth = dot(clip_z, vec4(p_eye, 1.0)) / dot(clip_w, vec4(p_eye, 1.0));
  gl_FragDepth = min(depth, gl_FragCoord.z);  // keeps the promise of depth_less where rounding would break it
  write_surface(search.normal * local_from_eye, search.ray.eye_direction, item_words.y, item_words.x);
}
