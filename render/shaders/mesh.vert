// Instance of a triangle mesh.
#include "item.glsl"

layout(location = 0) in uint instance;
layout(location = 1) in vec3 position;
layout(location = 2) in vec3 normal;

out vec3 p_eye;
#if defined(COUNT_CROSSINGS) || defined(LIST_CROSSINGS)
#define CROSSINGS
layout(binding = 4) uniform usamplerBuffer enclosures;  // core::Enclosure
flat out uvec2 crossing_words;  // record, and whether front faces are those that a ray leaves through
#else
centroid out vec3 n_eye;
flat out uvec2 item_words;
#endif

void main() {
  Item item = fetch_item(instance, 4);
  mat3 eye_from_local = mat3(view.eye_from_world) * item.chunk_from_local;
  p_eye = eye_from_local * position + eye_origin(item);
  gl_Position = view.clip_from_eye * vec4(p_eye, 1.0);
#ifdef CROSSINGS
  uint enclosure = texelFetch(enclosures, int(instance)).x;
  if (enclosure == 0u) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // open meshes have no inside
  crossing_words = uvec2(instance, uint((enclosure == 2u) != (determinant(eye_from_local) < 0.0)));
#else
  // Cofactors instead of the inverse transpose: defined for singular placements too.
  mat3 m = eye_from_local;
  float mirror = determinant(m) < 0.0 ? -1.0 : 1.0;
  n_eye = mirror * (mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * normal);
  item_words = uvec2(item.id, item.material);
#endif
}
