layout(local_size_x = 64) in;
layout(binding = 0) uniform usamplerBuffer u_input;
layout(std430, binding = 0) writeonly buffer Output { uint squares[]; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= uint(textureSize(u_input))) return;
  uint value = texelFetch(u_input, int(i)).x;
  squares[i] = value * value;
}
