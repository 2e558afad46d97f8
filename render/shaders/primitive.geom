// Emits the proxy of one ray-cast primitive. primitive.vert has set it up.
#include "proxy.glsl"

layout(points) in;
layout(triangle_strip, max_vertices = 10) out;

layout(location = 0) in Setup setup[];

// Stages of a separable program must declare the same built-in variables, also those that nobody reads.
in gl_PerVertex {
  vec4 gl_Position;
} gl_in[];
out gl_PerVertex {
  vec4 gl_Position;
};
// Only four slots: a software rasteriser copies them for every triangle. Fragments fetch the rest again.
layout(location = 0) flat out vec4 local_from_eye[3];  // rows of the linear map; w: local origin of the ray through the
                                                       // anchor's pixel, relative to the shift
layout(location = 3) flat out uvec4 anchor;  // eye depth and shift in z (float bits), record, pixel x | y << 16

void main() {
  uint strips = kProxyStrips;
  for (int i = 0; i < setup[0].proxy.corners; ++i, strips >>= 3) {
    if (i == kFirstStrip) EndPrimitive();
    local_from_eye = setup[0].local_from_eye;
    anchor = setup[0].anchor;
    gl_Position = proxy_corner(setup[0].proxy, strips & 7u);
    EmitVertex();
  }
}
