// Sets up one ray-cast primitive of any kind for the frame: the anchor, from which fragments compute their rays, and
// the proxy. Only the anchor needs pairs of floats.
//
// With PROXY_CORNERS a primitive has eight vertices, and each does all of this and places its corner of the proxy.
// Otherwise a primitive is a point, and primitive.geom emits the proxy.
#include "item.glsl"
#include "make_proxy.glsl"
#include "internal_faces.glsl"

#ifndef GL_ES
out gl_PerVertex {
  vec4 gl_Position;
};
#endif
#ifdef PROXY_CORNERS
// As in primitive.geom.
layout(location = 0) flat out vec4 local_from_eye[3];
layout(location = 3) flat out uvec4 anchor;
Setup setup;
const uint kVertices = 8u;
#else
layout(location = 0) out Setup setup;
const uint kVertices = 1u;
#endif

// Beyond the right edge of every view, so that triangles of nothing are dropped before they are set up.
const vec4 kNowhere = vec4(2.0, 0.0, 0.0, 1.0);

// Rays start from an anchor, a point of the primitive near its visible part. This stage takes the ray through the
// anchor's pixel to the anchor's depth in pairs. Each fragment takes the small step to its own pixel in float. So
// precision does not suffer from a distant eye or, with long thin primitives, from a distant local origin.
struct Anchor {
  vec3 local;
  Pair3 eye;
  float depth;
  vec2 pixel;
};

// Chooses the box's point nearest to the middle of the view, at the depth of the box's point nearest to the eye.
Anchor choose_anchor(Item item, LocalBox box, mat3 eye_from_local, mat3 rows, vec3 origin, vec3 local_eye) {
  vec3 nearest = perspective_view() ? clamp(local_eye, box.low, box.high) : 0.5 * (box.low + box.high);
  float depth = max(0.0, -(eye_from_local * nearest + origin).z);
  vec3 middle = eye_point(0.5 * view.viewport.xy, depth);
  Anchor a;
  a.local = leading_bits(clamp((middle - origin) * rows, box.low, box.high));
  a.eye = eye_position(item, a.local);
  a.depth = max(0.0, -a.eye.high.z);
  vec2 first = eye_point(vec2(0.0), a.depth).xy, step_size = eye_step(vec2(1.0), a.depth).xy;
  bool seen = step_size.x != 0.0 && step_size.y != 0.0;  // false when the depth is 0
  a.pixel = seen ? floor(clamp((a.eye.high.xy - first) / step_size, vec2(0.0), vec2(65535.0))) : vec2(0.0);
  return a;
}

void main() {
  uint record = record_of(kVertices);
  Item item = fetch_item(record, texels_per_record);
  mat3 eye_from_local = view.eye_from_world * item.chunk_from_local;
  vec3 yz = cross(eye_from_local[1], eye_from_local[2]);
  float volume = dot(eye_from_local[0], yz);
  // Otherwise there is nothing to see. No branch, for the reason that make_proxy.glsl names.
  bool placed = abs(volume) > 0.0 && abs(volume) < 3e38;
  mat3 rows =
      mat3(yz, cross(eye_from_local[2], eye_from_local[0]), cross(eye_from_local[0], eye_from_local[1])) * (1.0 / volume);
  vec3 origin = eye_origin(item);
  vec3 local_eye = -(origin * rows);
  LocalBox box = local_box(record, item.extra);

  Anchor a = choose_anchor(item, box, eye_from_local, rows, origin, local_eye);
  vec3 axis = box.axis * a.local.z;
  Pair3 ray = exact_eye_point(a.pixel, a.depth);
  precise vec3 from_anchor = (ray.high - a.eye.high) + (ray.low - a.eye.low);
  vec3 start = a.local - axis + from_anchor * rows;
  for (int i = 0; i < 3; ++i) setup.local_from_eye[i] = vec4(rows[i], start[i]);
  setup.anchor = uvec4(floatBitsToUint(a.depth), floatBitsToUint(axis.z), record, uint(a.pixel.x) | uint(a.pixel.y) << 16);

  // Widens the box on each side by a fraction of a pixel, at the depth of the farthest corner. Rasterisers round
  // corners to such fractions, and neighbours that meet in a plane must not both miss a pixel there. Occluders count on
  // that, too (culling::SolidOccluders::kProxyMargin).
  vec3 reach = 0.5 * (box.high - box.low);
  vec3 towards_eye = vec3(eye_from_local[0].z, eye_from_local[1].z, eye_from_local[2].z);
  float farthest = dot(abs(towards_eye), reach) - dot(towards_eye, box.low + reach) - origin.z;
  vec2 size = abs(eye_step(vec2(1.0), max(farthest, 0.0)).xy) * (1.0 / 32.0);
  vec3 margin = 1e-5 * reach + max(size.x, size.y) * vec3(length(rows[0]), length(rows[1]), length(rows[2]));
  if (internal_faces(item.material) != 0u) margin += kInternalCapOverlap;

  vec3 viewer = vec3(rows[0].z, rows[1].z, rows[2].z);
  bool inside = false;
  if (perspective_view()) {
    vec3 around = 2.0 * margin + kInsideMargin * (box.high - box.low);
    inside = all(greaterThan(local_eye, box.low - around)) && all(lessThan(local_eye, box.high + around));
    viewer = local_eye - 0.5 * (box.low + box.high);
  }
  setup.proxy = make_proxy(box.low - margin, box.high + margin, viewer, inside, eye_from_local, volume < 0.0, a.local, a.eye.high);
  if (!placed) setup.proxy.corners = 0;
#ifdef PROXY_CORNERS
  local_from_eye = setup.local_from_eye;
  anchor = setup.anchor;
  gl_Position = setup.proxy.corners == 0 ? kNowhere : proxy_corner(setup.proxy, vertex_number() & 7u);
#else
  gl_Position = vec4(0.0);
#endif
}
