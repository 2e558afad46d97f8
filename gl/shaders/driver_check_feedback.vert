flat out uint name;
void main() { name = uint(gl_VertexID); }
