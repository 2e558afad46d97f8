// Proxy geometry of a ray-cast primitive: the sides of its local box that look at the viewer, as three quads over seven corners. Only
// front faces are drawn, so the written depth never lies in front of the proxy's (depth_less in reverse-Z) and early depth tests
// stay. With the eye inside the box no side looks at it: the whole near plane is the proxy then.

struct LocalBox {
  vec3 low, high;
};

// Wider than the rounding of the eye's local position, in box sizes: an eye on a face counts as inside.
const float kInsideMargin = 1e-4;

// Which corner vertex gl_VertexID % 8 is, whose bits say on which axes it lies on the viewer's side, of the box with a margin around.
// `viewer` is the eye's local position, or in orthographic views the direction towards the viewer; `mirrored` tells a left-handed
// placement. False when the eye is inside: `corner` is then that of the screen, in -1 to 1.
bool proxy_corner(LocalBox box, vec3 margin, vec3 viewer, bool mirrored, out vec3 corner) {
  bvec3 towards = bvec3((gl_VertexID & 1) != 0, (gl_VertexID & 2) != 0, (gl_VertexID & 4) != 0);
  if (perspective_view()) {
    vec3 around = 2.0 * margin + kInsideMargin * (box.high - box.low);
    if (all(greaterThan(viewer, box.low - around)) && all(lessThan(viewer, box.high + around))) {
      // The first side covers the screen, the corners of the others fall together.
      vec2 uv = towards.x ? vec2(towards.y, towards.z) : vec2(1.0);
      corner = vec3(2.0 * uv - 1.0, 1.0);
      return false;
    }
    viewer -= 0.5 * (box.low + box.high);
  }
  bvec3 positive = greaterThanEqual(viewer, vec3(0.0));
  // Each side taken at its low coordinate, and a mirrored placement, turns the winding: two axes change places to turn it back.
  bool turned = (positive.x ^^ positive.y ^^ positive.z) == mirrored;
  if (turned) towards = towards.yxz;
  corner = mix(box.low - margin, box.high + margin, equal(towards, positive));
  return true;
}
