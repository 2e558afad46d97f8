// The whole viewport, or with HALF its lower left half, without any attribute. SLOPE: over 8 x 8 pixels, u_depth plus
// (x + 2 y) / 64.
uniform float u_depth;
#include "plane.glsl"

void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
#ifdef HALF
  corner = vec2(gl_VertexID == 1 ? 1.0 : -1.0, gl_VertexID == 2 ? 1.0 : -1.0);
#endif
  float depth = plane_depth();
#ifdef SLOPE
  depth += dot(4.0 * (corner + 1.0), vec2(1.0, 2.0)) / 64.0;
#endif
  gl_Position = vec4(corner, depth, 1.0);
}
