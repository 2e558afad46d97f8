// Writes elements of several words to scattered places: gpuscene/internal/element_writer.h.

// WORD is what one invocation moves: uint, or uvec4 when an element consists of uvec4.

layout(local_size_x = INVOCATIONS) in;

layout(std430, binding = 0) readonly restrict buffer Source {
  WORD source[];
};
layout(std430, binding = 1) writeonly restrict buffer Target {
  WORD target[];
};
layout(std430, binding = 2) readonly restrict buffer Places {
  uint places[];
};
layout(location = 0) uniform uint elements;
layout(location = 1) uniform uint words;  // per element

void main() {
  uint step = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
  for (uint i = gl_GlobalInvocationID.x; i < elements * words; i += step) {
    uint element = i / words;
    target[places[element] * words + i - element * words] = source[i];
  }
}
