layout(location = 0) flat in vec4 rows[4];
layout(location = 0) out uint number;
void main() { number = uint(dot(rows[0] + rows[1], rows[2] + rows[3])); }
