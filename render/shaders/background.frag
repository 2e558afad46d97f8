// A colour that changes evenly from the lower border of an image to the upper one.
#include "srgb.glsl"

layout(location = 0) uniform ivec2 corner;  // of the image in the framebuffer, pixels
layout(location = 2) uniform int linear_colour;
layout(location = 3) uniform vec3 bottom;  // sRGB
layout(location = 4) uniform vec3 top;
layout(location = 5) uniform float height;  // pixels

layout(location = 0) out vec4 colour;

void main() {
  vec3 mixed = mix(bottom, top, (gl_FragCoord.y - float(corner.y)) / height);
  colour = vec4(linear_colour != 0 ? linear_of(mixed) : mixed, 1.0);
}
