// Rasterised surfaces: meshes and lines.
#include "sections.glsl"
#include "payload.glsl"
#include "shading.glsl"

layout(location = 0) in vec3 p_eye;
layout(location = 1) centroid in vec3 n_eye;
layout(location = 2) flat in uvec2 item_words;
#ifdef SECTIONS
layout(location = 3) in vec4 section_value[2];
#endif

void main() {
  vec3 flat_normal = cross(dFdx(p_eye), dFdy(p_eye));  // not defined behind a discard of a neighbour
#ifdef SECTIONS
  if (!sections_keep(section_value)) discard;
#endif
  if (dithered_away(item_words.y, item_words.x)) discard;
  vec3 n = (item_words.y & kFlatShaded) != 0u ? flat_normal : n_eye;
  write_surface(n, perspective_view() ? p_eye : vec3(0.0, 0.0, -1.0), 0.0, item_words.y, item_words.x);
}
