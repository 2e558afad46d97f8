// Proxy of one ray-cast primitive; which one is chosen by a define.
#define VERTEX_STAGE
#include "view.glsl"
#include "payload.glsl"
#include "proxy.glsl"
#ifdef CYLINDER
#include "cylinder.glsl"
#endif
#ifdef SNOUT
#include "snout.glsl"
#endif
#ifdef CIRCULAR_TORUS
#include "circular_torus.glsl"
#endif

flat out mat3 local_from_eye;
flat out vec3 local_eye;      // local position of the eye-space origin
flat out uvec3 item_words;    // item id, material and flags, instance
flat out float item_extra;

void main() {
  uint instance = record_of(8u);
  Item item = fetch_item(instance, kTexelsPerItem);
  float volume = determinant(item.eye_from_local);
  if (volume == 0.0 || isnan(volume)) {  // singular placement: nothing to see
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
    return;
  }
  local_from_eye = inverse(item.eye_from_local);
  local_eye = -(local_from_eye * item.origin);
  item_words = uvec3(item.id, item.material, instance);
  item_extra = item.extra;
  vec3 viewer = perspective_view() ? local_eye : local_from_eye * vec3(0.0, 0.0, 1.0);
  gl_Position = proxy_position(item, local_box(item, instance), viewer, volume < 0.0);
}
