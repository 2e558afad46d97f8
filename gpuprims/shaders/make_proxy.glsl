// Chooses a primitive's proxy: see proxy.glsl.
#include "kept_ray.glsl"
#include "local_box.glsl"
#include "proxy.glsl"

// Margin in box sizes, wider than the rounding of the eye's local position. An eye on a face counts as inside.
const float kInsideMargin = 1e-4;

// Up to this many pixels along each side, a rectangle costs less than a box.
const float kWidestRectangle = 8.0;

const Proxy kNothing = Proxy(vec4(0.0), vec4[3](vec4(0.0), vec4(0.0), vec4(0.0)), vec3(0.0), vec3(0.0), 0);

// Rectangle between two corners, in -1 to 1.
Proxy rectangle_proxy(vec2 low, vec2 high, float depth) {
  vec2 size = high - low;
  return Proxy(vec4(low, depth, 1.0), vec4[3](vec4(0.0), vec4(size.x, 0.0, 0.0, 0.0), vec4(0.0, size.y, 0.0, 0.0)), vec3(1.0), vec3(0.0),
               kRectangleCorners);
}

// `viewer`: as in make_proxy. `local` is a point of the box, `eye` the same in eye space.
Proxy box_proxy(vec3 low, vec3 high, vec3 viewer, mat3 eye_from_local, bool mirrored, vec3 local, vec3 eye) {
  Proxy proxy;
  proxy.corners = kBoxCorners;
  proxy.origin = view.clip_from_eye * vec4(eye, 1.0);
  for (int i = 0; i < 3; ++i) proxy.sides[i] = view.clip_from_eye * vec4(eye_from_local[i], 0.0);
  bvec3 positive = greaterThanEqual(viewer, vec3(0.0));
  proxy.near_steps = mix(low, high, positive) - local;
  proxy.far_steps = mix(high, low, positive) - local;
  // Taking a side at its low coordinate reverses the winding, and so does a mirrored placement. Swapping two axes
  // reverses it back.
  if ((positive.x ^^ positive.y ^^ positive.z) == mirrored) {
    vec4 side = proxy.sides[0];
    proxy.sides[0] = proxy.sides[1];
    proxy.sides[1] = side;
    proxy.near_steps.xy = proxy.near_steps.yx;
    proxy.far_steps.xy = proxy.far_steps.yx;
  }
  return proxy;
}

// The proxy of a box that already includes its margin. `viewer` is the eye's local position, or in orthographic views
// the direction towards the viewer. `inside`: the eye is inside the box. `mirrored`: the placement is left-handed. It
// branches last, since a software rasteriser compiles what reads a uniform in a branch to eight loads.
Proxy make_proxy(vec3 low, vec3 high, vec3 viewer, bool inside, mat3 eye_from_local, bool mirrored, vec3 local, vec3 eye) {
  Proxy sides = box_proxy(low, high, viewer, eye_from_local, mirrored, local, eye);
  // Pixels of the box's bounding box in eye space. The smaller the box, the tighter they fit.
  vec3 reach = 0.5 * (high - low), centre = eye + eye_from_local * (low + reach - local);
  vec3 extent = abs(eye_from_local[0]) * reach.x + abs(eye_from_local[1]) * reach.y + abs(eye_from_local[2]) * reach.z;
  float nearest = -centre.z - extent.z, farthest = extent.z - centre.z;
  vec2 below = centre.xy - extent.xy, above = centre.xy + extent.xy;
  vec2 first = min(pixel_at(below, nearest), pixel_at(below, farthest)), last = max(pixel_at(above, nearest), pixel_at(above, farthest));
#ifdef SAMPLES
  first = floor(first);
  last = floor(last);
#else
  first = max(ceil(first - 0.5), vec2(0.0));
  last = min(floor(last - 0.5), view.viewport.xy - 1.0);
#endif
  vec2 pixel = 2.0 / view.viewport.xy;
  float depth = depth_at(nearest);
  bool in_front = nearest > 0.0 || !perspective_view();
  if (inside) return rectangle_proxy(vec2(-1.0), vec2(1.0), 1.0);
  if (in_front && any(greaterThan(first, last))) return kNothing;
  if (in_front && all(lessThan(last - first, vec2(kWidestRectangle))))
    return rectangle_proxy(first * pixel - 1.0, (last + 1.0) * pixel - 1.0, depth);
  return sides;
}
