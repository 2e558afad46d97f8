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
#ifdef SPHERE_CAP
#include "sphere_cap.glsl"
#endif

// Four slots, no more: a software rasteriser copies them for every triangle. The rest is fetched again per pixel.
flat out vec4 local_from_eye[3];  // rows of the affine map: direction xyz, origin w
flat out uint record;

void main() {
  record = record_of(8u);
  Item item = fetch_item(record, kTexelsPerItem);
  float volume = determinant(item.eye_from_local);
  if (volume == 0.0 || isnan(volume)) {  // singular placement: nothing to see
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
    return;
  }
  mat3 linear = inverse(item.eye_from_local);
  vec3 local_eye = -(linear * item.origin);
  mat3 rows = transpose(linear);
  for (int i = 0; i < 3; ++i) local_from_eye[i] = vec4(rows[i], local_eye[i]);
  vec3 viewer = perspective_view() ? local_eye : linear * vec3(0.0, 0.0, 1.0);
  gl_Position = proxy_position(item, local_box(item, record), viewer, volume < 0.0);
}
