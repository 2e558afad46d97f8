// Proxies of ray-cast primitives in three.js: those of primitive.vert, in the clip space of the renderer.
#include "es.glsl"
#define PROXY_CORNERS
#define main place_corner
#include "primitive.vert"
#undef main

// Reversed depth in clip space, just behind the near plane wherever w is that of the proxy's corner. Sides of a box in
// perspective may begin beside the eye or behind it. They are clipped at half the near plane's distance, since they must
// not come near to w = 0, and their depth is as little behind the near plane as will keep rounding errors of the
// farthest corner's w from moving that clip.
float depth_behind_near(float w, float farthest) {
  if (setup.proxy.corners == kRectangleCorners || !perspective_view()) return w * (1.0 - 1e-6);
  float near = -view.clip_from_eye[2].w * view.depth_range.x;
  return w - min(2e-6 * farthest / near, 0.1) * (w - 0.5 * near);
}

void main() {
  place_corner();
  // WebGL has no depth clamp. A proxy that the near plane would cut moves behind it as a whole: moved one by one,
  // corners could hide hits. Fragments begin their rays at the near plane anyway.
  bool cut = false;
  float farthest = 0.0;
  for (uint corner = 0u; corner < 8u; ++corner) {
    vec4 place = proxy_corner(setup.proxy, corner);
    cut = cut || place.z > place.w;
    farthest = max(farthest, place.w);
  }
  if (cut) gl_Position.z = depth_behind_near(gl_Position.w, farthest);
#ifndef REVERSED_DEPTH
  gl_Position.z = gl_Position.w - 2.0 * gl_Position.z;
#endif
}
