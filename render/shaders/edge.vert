// A part of a line, as wide as it is in the image: render/internal/edge_pass.h. Six vertices a part, an instance a line.
layout(location = 0) uniform mat4 clip_from_eye;
layout(location = 1) uniform vec3 image;  // size in pixels; half the width of lines and what smooths it

#ifdef CURVES
layout(location = 0) in vec3 centre;
layout(location = 1) in vec3 u;
layout(location = 2) in vec3 v;
layout(location = 3) in vec2 sweep_strength;
layout(location = 3) uniform int parts;
#define STRENGTH sweep_strength.y
#else
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
layout(location = 2) uniform mat4 eye_from_mesh;
layout(location = 3) uniform float strength;
#define STRENGTH strength
#endif

layout(location = 0) flat out vec4 ends;     // pixels
layout(location = 1) flat out vec3 depths;  // of both ends; strength

vec3 eye_point(int i) {
#ifdef CURVES
  float t = sweep_strength.x * float(i) / float(parts);
  return centre + cos(t) * u + sin(t) * v;
#else
  return (eye_from_mesh * vec4(i == 0 ? from : to, 1.0)).xyz;
#endif
}

// Lines are cut well outside of the image, where its numbers are still exact, and at the near plane.
const float kGuard = 4.0;

float inside(vec4 p, int side) {
  return side == 4 ? p.w - p.z : kGuard * p.w + (side < 2 ? p.x : p.y) * ((side & 1) == 0 ? 1.0 : -1.0);
}

void main() {
  int part = gl_VertexID / 6, corner = gl_VertexID % 6;
  vec4 p = clip_from_eye * vec4(eye_point(part), 1.0), q = clip_from_eye * vec4(eye_point(part + 1), 1.0);
  vec2 kept = vec2(0.0, 1.0);
  for (int side = 0; side < 5; ++side) {
    vec2 d = vec2(inside(p, side), inside(q, side));
    if (d.x < 0.0 && d.y < 0.0) kept.y = -1.0;
    else if (d.x < 0.0) kept.x = max(kept.x, d.x / (d.x - d.y));
    else if (d.y < 0.0) kept.y = min(kept.y, d.x / (d.x - d.y));
  }
  vec4 a = mix(p, q, kept.x), b = mix(p, q, kept.y);
  if (!(kept.x <= kept.y) || !(a.w > 0.0) || !(b.w > 0.0)) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    ends = vec4(0.0);
    depths = vec3(0.0);
    return;
  }
  ends = (0.5 + 0.5 * vec4(a.xy / a.w, b.xy / b.w)) * image.xyxy;
  depths = vec3(a.z / a.w, b.z / b.w, STRENGTH);
  vec2 along = ends.zw - ends.xy;
  float size = length(along);
  along = size > 0.0 ? along / size : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  bool last = corner == 1 || corner == 2 || corner == 4, left = corner == 2 || corner == 4 || corner == 5;
  vec2 place = (last ? ends.zw + image.z * along : ends.xy - image.z * along) + (left ? image.z : -image.z) * across;
  gl_Position = vec4(place / image.xy * 2.0 - 1.0, 0.0, 1.0);
}
