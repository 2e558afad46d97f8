// Ray-casts one primitive inside its proxy.
#include "view.glsl"
#include "payload.glsl"
#include "primitive.glsl"
#include "kept_ray.glsl"
#include "sample_place.glsl"
#ifndef PLAIN_DEPTH
layout(depth_less) out float gl_FragDepth;
#endif
#define SURFACE_DEPTH gl_FragDepth
#include "shading.glsl"
#include "hatching.glsl"

layout(location = 0) flat in vec4 local_from_eye[3];
layout(location = 3) flat in uvec4 anchor;

// Result of a ray: local position, depth, and everything that shading needs.
struct RayHit {
  vec3 p;
  float depth;
  int face;
  int section;  // of a cut face
};

// section_values() on a ray, at a place beside the primitive's anchor.
vec4[2] values_beside_anchor(vec3 beside) {
  vec4 values[2] = vec4[2](vec4(0.0), vec4(0.0));
#ifdef SECTIONS
  vec3 offset, reach = shape_reach();
  mat3 linear = chunk_from_local(anchor.z, TEXELS_PER_RECORD, offset);
  float size = size_of(offset) + size_of(linear[0]) * reach.x + size_of(linear[1]) * reach.y + size_of(linear[2]) * reach.z;
  Pair3 exact = exact_eye_point(vec2(anchor.w & 0xffffu, anchor.w >> 16), uintBitsToFloat(anchor.x));
  section_values(exact, beside, size, values);
#endif
  return values;
}

// Casts the ray through a pixel coordinate; false when it hits nothing.
bool cast_ray(vec2 pixel, mat3 rows, uint hidden, out RayHit hit) {
  float anchor_depth = uintBitsToFloat(anchor.x);
  vec2 from_anchor = pixel - vec2(anchor.w & 0xffffu, anchor.w >> 16);
  vec3 direction = eye_direction(pixel);
  vec3 d = direction * rows;
  vec3 o = vec3(local_from_eye[0].w, local_from_eye[1].w, local_from_eye[2].w) + eye_step(from_anchor, anchor_depth) * rows;
  // Moves the origin to the ray's closest approach: there coordinates are about as small as the primitive.
  float start = -dot(o, d) / dot(d, d);
  o += start * d;
  vec4 values[2] = values_beside_anchor(eye_step(from_anchor, anchor_depth) + start * direction);
  start += anchor_depth;
  Search search = search_kept(start, direction, values, hidden, hit.section);
  intersect_primitive(search, o, d);
  hit.p = o + search.t * d;
  hit.depth = start + search.t;
  hit.face = search.face;
  return search.t != kNoHit;
}

void main() {
  vec2 place = fragment_place();
  float proxy_depth = fragment_depth(place);
  uint record = anchor.z;
  uvec4 words = payload_texel(record, TEXELS_PER_RECORD, 3);  // chunk, item id, material and flags, first shape parameter
  if (dithered_away(words.z, words.y)) discard;
  load_shape(record, uintBitsToFloat(words.w), uintBitsToFloat(anchor.y));
  mat3 rows = mat3(local_from_eye[0].xyz, local_from_eye[1].xyz, local_from_eye[2].xyz);
  uint hidden = internal_faces(words.z);
  RayHit hit;
#ifdef SAMPLES
  gl_SampleMask[0] = 1 << gl_SampleID;  // each sample runs the shader, and casts the ray through its own place
#endif
  if (!cast_ray(place, rows, hidden, hit)) discard;
#ifdef SECTIONS
  if (hit.face == kCut) hit.depth = cut_depth(place, hit.section);  // one depth for all solids that overlap
#endif
  gl_FragDepth = min(depth_at(hit.depth), proxy_depth);  // depth_less must hold despite rounding
  bool cut = hit.face == kCut;
  vec3 normal = cut ? cut_normal(hit.section) : rows * face_normal(hit.p, hit.face);
  float hatch = cut ? hatch_cover(place, hit.section, words.y) : 0.0;
  write_surface(normal, eye_direction(place), hatch, words.z, words.y);
}
