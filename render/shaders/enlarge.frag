// A smaller image over all of a larger one: its colours are interpolated, depth and id are those of the nearest pixel.
layout(location = 3) uniform vec2 scale;  // pixels of the smaller image for one of the larger

layout(binding = 0) uniform sampler2D colours;
layout(binding = 1) uniform sampler2D depths;
layout(location = 0) out vec4 colour;
#if IDS
layout(binding = 2) uniform usampler2D ids;
layout(location = 1) out uint id;
#endif

void main() {
  vec2 at = gl_FragCoord.xy * scale;
  ivec2 last = textureSize(colours, 0) - 1;
  ivec2 nearest = min(ivec2(at), last);
  gl_FragDepth = texelFetch(depths, nearest, 0).r;
#if IDS
  id = texelFetch(ids, nearest, 0).x;
#endif
  vec2 corner = floor(at - 0.5), part = at - 0.5 - corner;
  ivec2 low = max(ivec2(corner), ivec2(0)), high = min(ivec2(corner) + 1, last);
  colour = mix(mix(texelFetch(colours, low, 0), texelFetch(colours, ivec2(high.x, low.y), 0), part.x),
               mix(texelFetch(colours, ivec2(low.x, high.y), 0), texelFetch(colours, high, 0), part.x), part.y);
}
