uniform vec4 u_color;
uniform uint u_id;
layout(location = 0) out vec4 o_color;
layout(location = 1) out uint o_id;

void main() {
  o_color = u_color;
  o_id = u_id;
}
