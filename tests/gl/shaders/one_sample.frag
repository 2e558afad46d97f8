// One sample of each pixel of an image.
layout(binding = 0) uniform sampler2DMS samples;
uniform int u_sample;
layout(location = 0) out vec4 o_value;

void main() { o_value = texelFetch(samples, ivec2(gl_FragCoord.xy), u_sample); }
