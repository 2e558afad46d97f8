layout(location = 0) in uint a_value;
flat out uint v_doubled;

void main() {
  gl_Position = vec4(0.0);
  v_doubled = FACTOR * a_value;
}
