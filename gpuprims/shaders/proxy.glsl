// What is rasterised for a ray-cast primitive, one of:
//   - The three sides of its box that face the viewer. They are front faces only, so the written depth never lies in
//     front of the proxy's (depth_less in reverse-Z), and early depth tests stay on.
//   - A rectangle at one depth. If the eye is inside the box, no side faces it: the rectangle is the whole screen at
//     the near plane. If the box covers few pixels, it is those pixels at the depth of the box's nearest corner.
//   - Nothing, if the box covers no pixel centre: no ray is cast beside one.

// Bit i of corner c is set when the corner lies on the viewer's side along axis i. Its position in clip space is the
// origin plus, for each axis, the side times the step to the near or the far end. A rectangle is the first side of a
// box without depth.
struct Proxy {
  vec4 origin, sides[3];
  vec3 near_steps, far_steps;
  int corners;  // number of corners of kProxyStrips to draw: 0, kRectangleCorners or kBoxCorners
};

const int kRectangleCorners = 4, kBoxCorners = 10;

// Two strips of corners, counter-clockwise from outside, as octal digits from the lowest on: 1, 3, 5, 7, 4, 6 and 2, 6,
// 3, 7. gpuscene::kProxyTriangles has the same as triangles. Of a rectangle these have no area from the third on.
const uint kProxyStrips = 07362647531u;
const int kFirstStrip = 6;  // length of the first strip

// Moves proxies nearer by this factor: rounding must not put a hit in front of its proxy (depth_less).
const float kNearer = 1.0 + 1e-6;

vec4 proxy_corner(Proxy proxy, uint corner) {
  vec3 steps = mix(proxy.far_steps, proxy.near_steps, bvec3((corner & 1u) != 0u, (corner & 2u) != 0u, (corner & 4u) != 0u));
  vec4 place = proxy.origin + steps.x * proxy.sides[0] + steps.y * proxy.sides[1] + steps.z * proxy.sides[2];
  place.z *= kNearer;
  return place;
}

// What the vertex stage computes for a primitive's fragments (see primitive.vert) and for what draws its proxy.
struct Setup {
  vec4 local_from_eye[3];
  uvec4 anchor;
  Proxy proxy;
};
