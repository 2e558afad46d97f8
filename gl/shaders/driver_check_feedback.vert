// Numbers for the geometry stage.
layout(location = 0) flat out uint name;
void main() { name = uint(gl_VertexID); }
