// What the culler's shaders take for the boxes of items: one work group per cluster.
#include "item_test.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = 0) writeonly buffer Boxes {
  float boxes[];  // per item: 1 when it is there, low, high
};

void main() {
  vec3 low, high;
  bool there = item_present(gl_WorkGroupID.x, gl_LocalInvocationIndex);
  item_box(gl_WorkGroupID.x, gl_LocalInvocationIndex, low, high);
  uint at = 7u * gl_GlobalInvocationID.x;
  boxes[at] = there ? 1.0 : 0.0;
  for (uint i = 0u; i < 3u; ++i) {
    boxes[at + 1u + i] = low[i];
    boxes[at + 4u + i] = high[i];
  }
}
