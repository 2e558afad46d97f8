// Screen-aligned square around a point: render/internal/point_splats.h.
#include "sections.glsl"

layout(location = 0) in vec4 place;  // centre in eye space; side in pixels
layout(location = 1) in uvec2 item;  // item id, row of the material table

layout(location = 0) flat out vec3 square;  // centre in pixels, half the side
layout(location = 1) flat out vec3 direction;
layout(location = 2) flat out uvec2 item_words;

// Rasterisers place and clip points in steps of their own, and may draw none smaller than a pixel. So points are drawn
// larger than the square, and fragments decide.
const float kMargin = 0.25;

void main() {
  gl_Position = view.clip_from_eye * vec4(place.xyz, 1.0);
  // A view without sections may name a mode that keeps nothing.
  vec4 values[2];
  section_values(Pair3(place.xyz, vec3(0.0)), vec3(0.0), size_of(place.xyz), values);
  if (view.flags.y > 0 && !sections_keep(values)) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = max(place.w, 1.0) + kMargin;
  square = vec3((0.5 + 0.5 * gl_Position.xy / gl_Position.w) * view.viewport.xy, 0.5 * place.w);
  direction = perspective_view() ? place.xyz : vec3(0.0, 0.0, -1.0);
  item_words = item;
}
