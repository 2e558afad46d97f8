// Blends lines over an image.
#include "srgb.glsl"

layout(binding = 0) uniform sampler2D covers;
layout(location = 0) uniform ivec2 corner;  // of the image in the framebuffer, pixels
layout(location = 2) uniform int linear_colour;
layout(location = 3) uniform vec3 line_colour;

layout(location = 0) out vec4 pixel;  // multiplied by its alpha

void main() {
  float cover = texelFetch(covers, ivec2(gl_FragCoord.xy) - corner, 0).r;
  if (cover == 0.0) discard;
  pixel = vec4((linear_colour != 0 ? linear_of(line_colour) : line_colour) * cover, cover);
}
