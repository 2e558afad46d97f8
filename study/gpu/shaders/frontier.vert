// One vertex per node of the cut.
layout(binding = 7) uniform usamplerBuffer cut;

layout(location = 0) flat out uint node;

void main() { node = texelFetch(cut, gl_VertexID).x; }
