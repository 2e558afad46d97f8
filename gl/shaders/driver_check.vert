// Draws what a check needs: one triangle over all, one over the left part up to `edge`, or points whose pixel tells
// their number.
layout(location = 0) uniform int shape;
layout(location = 1) uniform float edge;   // in clip coordinates
layout(location = 2) uniform float depth;  // of the triangle
layout(location = 3) uniform float points;  // pixels in a row

layout(location = 0) flat out uint number;

const int kPoints = 2;

void main() {
  number = uint(gl_VertexID);
  gl_PointSize = 1.0;
  if (shape == kPoints) {
    gl_Position = vec4((float(gl_VertexID) + 0.5) / points * 2.0 - 1.0, 1.0 / points, depth, 1.0);
    return;
  }
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0;
  // The long side of the half triangle is a vertical line at `edge`.
  gl_Position = shape == 0 ? vec4(corner - 1.0, depth, 1.0)
                           : vec4(edge - corner.x, 3.0 - corner.y * 2.0 - corner.x, depth, 1.0);
}
