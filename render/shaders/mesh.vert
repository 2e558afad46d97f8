// Instance of a triangle mesh.
#include "item.glsl"

layout(location = 0) in uint instance;
layout(location = 1) in vec3 position;
layout(location = 2) in vec3 normal;

out vec3 p_eye;
out vec3 n_eye;
flat out uvec2 item_words;

void main() {
  Item item = fetch_item(instance, 4);
  mat3 eye_from_local = mat3(view.eye_from_world) * item.chunk_from_local;
  p_eye = eye_from_local * position + vec3(eye_position(item, vec3(0.0)));
  // Cofactors instead of the inverse transpose: defined for singular placements too.
  mat3 m = eye_from_local;
  float mirror = determinant(m) < 0.0 ? -1.0 : 1.0;
  n_eye = mirror * (mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * normal);
  item_words = uvec2(item.id, item.material);
  gl_Position = view.clip_from_eye * vec4(p_eye, 1.0);
}
