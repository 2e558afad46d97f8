// Box: the eight corners of the unit cube, scaled by the placement. Both sides are drawn, so the eye may be inside; normals follow
// from the fragment stage (the record is flagged flat-shaded).
#include "item.glsl"

out vec3 p_eye;
out vec3 n_eye;
flat out uvec2 item_words;

void main() {
  Item item = fetch_item(record_of(8u), 4);
  vec3 corner = vec3(gl_VertexID & 1, (gl_VertexID >> 1) & 1, (gl_VertexID >> 2) & 1) - 0.5;
  p_eye = item.eye_from_local * corner + item.origin;
  n_eye = vec3(0.0);
  item_words = uvec2(item.id, item.material);
  gl_Position = view.clip_from_eye * vec4(p_eye, 1.0);
}
