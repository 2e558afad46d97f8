// A small box, with about the arithmetic and the outputs of render/shaders/primitive.vert. With CORNERS each of its eight
// vertices does the work and is one of its corners; otherwise it is a point, for the geometry stage.
out gl_PerVertex {
  vec4 gl_Position;
};
#ifdef CORNERS
layout(location = 0) flat out vec4 rows[4];
const int kVertices = 8;
#else
layout(location = 0) out vec4 values[10];
const int kVertices = 1;
#endif

void main() {
  vec4 sum = vec4(gl_VertexID / kVertices + gl_InstanceID);
  for (int i = 0; i < 100; ++i) sum = fract(sum * 1.25 + sum.yzwx);
  vec4 place = vec4(sum.xyz, 1.0);
#ifdef CORNERS
  for (int i = 0; i < 4; ++i) rows[i] = sum * float(i + 1);
  gl_Position = place + 1e-3 * sum * vec4(gl_VertexID & 1, gl_VertexID & 2, gl_VertexID & 4, 0);
#else
  for (int i = 0; i < 9; ++i) values[i] = sum * float(i + 1);
  values[9] = place;
  gl_Position = vec4(0.0);
#endif
}
