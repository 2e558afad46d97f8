// A test's own shader.
// What shaders make of pairs of floats: case i of each, as high and low parts.
#include "pairs.glsl"

layout(local_size_x = 64) in;

struct Case {
  vec4 matrix[3], rest[3];  // columns, as ViewBlock::eye_from_world_parts
  vec4 a, a_low, b, b_low;
};
struct Answer {
  vec4 high, low;
};
layout(std430, binding = 0) readonly restrict buffer Cases {
  Case cases[];
};
layout(std430, binding = 1) writeonly restrict buffer Answers {
  Answer answers[];  // four of each case
};
layout(location = 0) uniform uint count;

void answer(uint i, Pair3 pair) { answers[i] = Answer(vec4(pair.high, 0.0), vec4(pair.low, 0.0)); }

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  Case c = cases[i];
  Pair3 a = Pair3(c.a.xyz, c.a_low.xyz), b = Pair3(c.b.xyz, c.b_low.xyz);
  answer(4u * i, pair_sum(a, b));
  answer(4u * i + 1u, pair_cross(a, b));
  answer(4u * i + 2u, pair_transform(mat3(c.matrix[0].xyz, c.matrix[1].xyz, c.matrix[2].xyz),
                                     mat3(c.rest[0].xyz, c.rest[1].xyz, c.rest[2].xyz), a));
  answer(4u * i + 3u, Pair3(vec3(pair_total(pair_product(a, b))), vec3(0.0)));
}
