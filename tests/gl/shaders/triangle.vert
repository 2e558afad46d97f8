// The whole viewport, or with HALF its lower left half, without any attribute.
uniform float u_depth;
#include "plane.glsl"

void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
#ifdef HALF
  corner = vec2(gl_VertexID == 1 ? 1.0 : -1.0, gl_VertexID == 2 ? 1.0 : -1.0);
#endif
  gl_Position = vec4(corner, plane_depth(), 1.0);
}
