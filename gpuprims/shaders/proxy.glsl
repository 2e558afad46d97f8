// What is rasterised for a ray-cast primitive. Either the three sides of its box that look at the viewer: front faces alone, so the
// written depth never lies in front of the proxy's (depth_less in reverse-Z) and early depth tests stay. Or a rectangle at one depth:
// the whole screen at the near plane with the eye inside the box, on which no side looks then; and where the box covers few pixels,
// those pixels at the depth of its nearest corner. Or nothing, where the box covers no pixel's centre: no ray is cast beside one.

// Corner c, whose bits say on which axes it lies on the viewer's side, is in clip space the origin and for each axis its side times the
// axis's step to the near or the far end. A rectangle is the first side of a box that has no depth.
struct Proxy {
  vec4 origin, sides[3];
  vec3 near_steps, far_steps;
  int corners;  // how many of kProxyStrips are drawn: 0, kRectangleCorners or kBoxCorners
};

const int kRectangleCorners = 4, kBoxCorners = 10;

// Two strips of corners, counter-clockwise from outside, in octal digits from the lowest on: 1, 3, 5, 7, 4, 6 and 2, 6, 3, 7.
const uint kProxyStrips = 07362647531u;
const int kFirstStrip = 6;  // its length

vec4 proxy_corner(Proxy proxy, uint corner) {
  vec3 steps = mix(proxy.far_steps, proxy.near_steps, bvec3((corner & 1u) != 0u, (corner & 2u) != 0u, (corner & 4u) != 0u));
  return proxy.origin + steps.x * proxy.sides[0] + steps.y * proxy.sides[1] + steps.z * proxy.sides[2];
}

// What the vertex stage finds of a primitive, for its fragments (see primitive.vert) and the stage that emits its proxy.
struct Setup {
  vec4 local_from_eye[3];
  uvec4 anchor;
  Proxy proxy;
};
