// Puts elements of some words each in their places: gpuscene/element_writer.h.

layout(local_size_x = INVOCATIONS) in;

layout(std430, binding = 0) readonly restrict buffer Source {
  uint source[];  // places, then the elements
};
layout(std430, binding = 1) writeonly restrict buffer Target {
  uint target[];
};
layout(location = 0) uniform uint elements;
layout(location = 1) uniform uint words;  // of an element

void main() {
  uint step = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
  for (uint i = gl_GlobalInvocationID.x; i < elements * words; i += step)
    target[source[i / words] * words + i % words] = source[elements + i];
}
