// Stands in for what GLSL ES 3.00, which WebGL2 has, lacks of GLSL 4.50. Every stage includes this file first.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

#define precise

// There are no buffer textures: texels lie in rows of a texture, which primitives.js makes.
const int kTexelRowBits = 11;

ivec2 place_of_texel(int index) { return ivec2(index & ((1 << kTexelRowBits) - 1), index >> kTexelRowBits); }

vec4 texel_at(sampler2D texels, int index) { return texelFetch(texels, place_of_texel(index), 0); }
uvec4 texel_at(usampler2D texels, int index) { return texelFetch(texels, place_of_texel(index), 0); }

#define samplerBuffer sampler2D
#define usamplerBuffer usampler2D
#define texelFetch(texels, index) texel_at(texels, index)
