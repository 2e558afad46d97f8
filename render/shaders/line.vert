// One-pixel line between the local points (0, 0, 0) and (1, 0, 0); the placement carries both ends.
#include "item.glsl"
#include "sections.glsl"

invariant gl_Position;  // passes of several programs meet at equal depths

layout(location = 0) out vec3 p_eye;
layout(location = 1) centroid out vec3 n_eye;
layout(location = 2) flat out uvec2 item_words;
#ifdef SECTIONS
layout(location = 3) out vec4 section_value[2];
#endif

void main() {
  Item item = fetch_item(record_of(2u), 4);
  Pair3 p = eye_position(item, vec3(float(gl_VertexID & 1), 0.0, 0.0));
  p_eye = p.high + p.low;
  n_eye = vec3(0.0, 0.0, 1.0);  // lit as if it faced the viewer
  item_words = uvec2(item.id, item.material);
#ifdef SECTIONS
  section_values(p, vec3(0.0), size_of(item.offset) + size_of(item.chunk_from_local[0]), section_value);
#endif
  gl_Position = view.clip_from_eye * vec4(p_eye, 1.0);
}
