// Lets the triangles of a proxy pass whose three vertices all found their planes passed.
layout(triangles) in;
layout(triangle_strip, max_vertices = 3) out;

flat in vec4 vertex_local_from_eye[3][3];
flat in uvec4 vertex_anchor[3];
flat in uint rejected[3];

flat out vec4 local_from_eye[3];
flat out uvec4 anchor;

void main() {
  if ((rejected[0] | rejected[1] | rejected[2]) != 0u) return;
  for (int i = 0; i < 3; ++i) {
    gl_Position = gl_in[i].gl_Position;
    local_from_eye = vertex_local_from_eye[i];
    anchor = vertex_anchor[i];
    EmitVertex();
  }
}
