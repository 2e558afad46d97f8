// Emits as much as render/shaders/primitive.geom does for a solid.
layout(points) in;
layout(triangle_strip, max_vertices = 10) out;

layout(location = 0) in vec4 values[][10];
layout(location = 0) flat out vec4 rows[4];

out gl_PerVertex {
  vec4 gl_Position;
};

void main() {
  for (int i = 0; i < 10; ++i) {
    if (i == 6) EndPrimitive();
    for (int k = 0; k < 4; ++k) rows[k] = values[0][k];
    gl_Position = values[0][9] + 1e-3 * vec4(i & 1, i & 2, i & 4, 0) * (values[0][4] + values[0][5] - values[0][8]);
    EmitVertex();
  }
}
