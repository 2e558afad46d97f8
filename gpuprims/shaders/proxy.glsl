// What is rasterised for a ray-cast primitive. Either the three sides of its box that look at the viewer: front faces alone, so the
// written depth never lies in front of the proxy's (depth_less in reverse-Z) and early depth tests stay. Or a rectangle at one depth:
// the whole screen at the near plane with the eye inside the box, on which no side looks then; and where the box covers few pixels,
// those pixels at the depth of its nearest corner. Or nothing, where the box covers no pixel's centre: no ray is cast beside one.

const int kNoProxy = 0, kBoxProxy = 1, kRectangleProxy = 2;

// In clip space. A box: corner c, whose bits say on which axes it lies on the viewer's side, is the origin and for each axis its side
// times the axis's step to the near or the far end. A rectangle: x and y of two corners in sides[0], the depth in origin.z.
struct Proxy {
  vec4 origin, sides[3];
  vec3 near_steps, far_steps;
  int form;
};

vec4 proxy_corner(Proxy proxy, int corner) {
  if (proxy.form == kRectangleProxy)
    return vec4((corner & 1) != 0 ? proxy.sides[0].z : proxy.sides[0].x, (corner & 2) != 0 ? proxy.sides[0].w : proxy.sides[0].y,
                proxy.origin.z, 1.0);
  bvec3 bits = bvec3((corner & 1) != 0, (corner & 2) != 0, (corner & 4) != 0);
  vec3 steps = mix(proxy.far_steps, proxy.near_steps, bits);
  return proxy.origin + steps.x * proxy.sides[0] + steps.y * proxy.sides[1] + steps.z * proxy.sides[2];
}
