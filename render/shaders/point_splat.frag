// The samples in a square, in one colour.
#include "view.glsl"
#include "shading.glsl"

layout(location = 0) flat in vec3 square;
layout(location = 1) flat in vec3 direction;
layout(location = 2) flat in uvec2 item_words;

#ifdef SAMPLES
layout(location = 1) uniform vec2 sample_offsets[SAMPLES];
#endif

// Squares side by side share no sample and leave none between them.
bool contains(vec2 place) {
  vec2 from = place - square.xy;
  return all(greaterThanEqual(from, vec2(-square.z))) && all(lessThan(from, vec2(square.z)));
}

void main() {
  if (dithered_away(item_words.y, item_words.x)) discard;
  vec2 centre = floor(gl_FragCoord.xy) + 0.5;
#ifdef SAMPLES
  int covered = 0;
  for (int i = 0; i < SAMPLES; ++i) covered |= int(contains(centre + sample_offsets[i])) << i;
  if (covered == 0) discard;
  gl_SampleMask[0] = covered;
#else
  if (!contains(centre)) discard;
#endif
  write_mean_surface(direction, item_words.y, item_words.x);
}
