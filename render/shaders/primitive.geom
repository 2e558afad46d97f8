// Emits the proxy of one ray-cast primitive, as primitive.vert has set it up.
#include "proxy.glsl"

layout(points) in;
layout(triangle_strip, max_vertices = 10) out;

in Setup {
  vec4 local_from_eye[3];
  uvec4 anchor;
  vec4 origin, sides[3];
  vec3 near_steps, far_steps;
  int form;
} setup[];

out gl_PerVertex {
  vec4 gl_Position;
};
// Four slots, no more: a software rasteriser copies them for every triangle. The rest is fetched again per pixel.
layout(location = 0) flat out vec4 local_from_eye[3];  // rows of the linear map; w: local origin of the ray through the anchor's pixel, from the shift
layout(location = 3) flat out uvec4 anchor;  // eye depth and shift in z (float bits), record, pixel x | y << 16

// Corners of two strips, counter-clockwise from outside, in octal digits from the lowest on: 1, 3, 5, 7, 4, 6 and 2, 6, 3, 7. A
// rectangle is one strip of four corners.
const uint kBoxStrips = 07362647531u, kRectangleStrip = 03210u;
// Proxies lie this part nearer: the depth of what is hit is no farther than theirs, which rounding could turn.
const float kNearer = 1.0 + 1e-6;
const int kFirstStrip = 6, kBoxCorners = 10, kRectangleCorners = 4;

void main() {
  Proxy proxy = Proxy(setup[0].origin, setup[0].sides, setup[0].near_steps, setup[0].far_steps, setup[0].form);
  if (proxy.form == kNoProxy) return;
  bool box = proxy.form == kBoxProxy;
  uint strips = box ? kBoxStrips : kRectangleStrip;
#ifdef EVERY_BOX  // as many triangles for each: corners that are left over fall together
  int count = kBoxCorners;
#else
  int count = box ? kBoxCorners : kRectangleCorners;
#endif
  for (int i = 0; i < count; ++i, strips >>= 3) {
    if (i == kFirstStrip) EndPrimitive();
    local_from_eye = setup[0].local_from_eye;
    anchor = setup[0].anchor;
    gl_Position = proxy_corner(proxy, int(strips & 7u));
    gl_Position.z *= kNearer;
    EmitVertex();
  }
}
