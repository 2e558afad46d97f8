// A pixel's ray in eye space, with eye depth as its parameter t, and the parts of it that the near plane, the far plane
// and the section planes keep.
#include "view.glsl"
#include "search.glsl"
#include "sections.glsl"

vec3 eye_direction(vec2 pixel) {
  return vec3(view.pixel_ray[0].z + view.pixel_ray[0].w * pixel.x,
              view.pixel_ray[1].z + view.pixel_ray[1].w * pixel.y, -1.0);
}

vec3 eye_point(vec2 pixel, float t) {
  vec2 start = vec2(view.pixel_ray[0].x + view.pixel_ray[0].y * pixel.x,
                    view.pixel_ray[1].x + view.pixel_ray[1].y * pixel.y);
  return vec3(start, 0.0) + t * eye_direction(pixel);
}

// eye_point() in pairs: of the two coefficients for each axis that are not 0, times the depth in perspective.
Pair3 exact_eye_point(vec2 pixel, float depth) {
  vec4 x = view.pixel_ray[0], y = view.pixel_ray[1], rest = view.pixel_ray_rest;
  bool perspective = perspective_view();
  vec2 start = perspective ? vec2(x.z, y.z) : vec2(x.x, y.x), slope = perspective ? vec2(x.w, y.w) : vec2(x.y, y.y);
  Pair3 p = pair_sum(pair_product(vec3(slope, 0.0), vec3(pixel, 0.0)), Pair3(vec3(start, -1.0), vec3(rest.xz, 0.0)));
  p.low += vec3(rest.yw * pixel, 0.0);
  float scale = perspective ? depth : 1.0;
  p = pair_product(p, Pair3(vec3(scale), vec3(0.0)));
  if (!perspective) p.high.z = -depth;
  return p;
}

// The step from one pixel's ray to another's, at the same depth.
vec3 eye_step(vec2 pixels, float t) {
  return vec3((view.pixel_ray[0].y + t * view.pixel_ray[0].w) * pixels.x,
              (view.pixel_ray[1].y + t * view.pixel_ray[1].w) * pixels.y, 0.0);
}

// Pixel coordinate of a point in eye space.
vec2 pixel_at(vec2 point, float depth) {
  vec4 x = view.pixel_ray[0], y = view.pixel_ray[1];
  return (point - vec2(x.x, y.x) - depth * vec2(x.z, y.z)) / (vec2(x.y, y.y) + depth * vec2(x.w, y.w));
}

// Reversed zero-to-one depth of eye depth t.
float depth_at(float t) {
  return (view.clip_from_eye[3].z - view.clip_from_eye[2].z * t) / (view.clip_from_eye[3].w - view.clip_from_eye[2].w * t);
}

// Sections are half-spaces. The kept part lies in all of them or, when they unite, in any of them. Along a ray, the
// part that lies in all is one span. When they unite, the part that lies in none is left out, which is also one span.
// Compiled without SECTIONS for views that have none. `depth`: of t = 0. `values`: section_values() there. `cut`: the section whose face cut solids show.
Search search_kept(float depth, vec3 direction, vec4 values[2], uint hidden, out int cut) {
  vec2 range = view.depth_range.xy - depth;
  Search search = search_within(range, hidden);
  cut = 0;
#ifdef SECTIONS
  int count = view.flags.y;
  bool unite = view.flags.z == 1;
  Span span = whole_line();  // faces: index of the section
  float side = unite ? -1.0 : 1.0;
  for (int i = 0; i < count; ++i)
    clip(span, side * values[i >> 2][i & 3], side * dot(view.sections[i].xyz, direction), i);
  if (!unite) {
    search.first = vec2(max(range.x, span.from), min(range.y, span.to));
    search.cut_first = span.from > range.x;
    cut = span.from_face;
  } else if (!is_empty(span)) {
    search.first.y = min(range.y, span.from);
    search.second = vec2(max(range.x, span.to), range.y);
    search.cut_second = span.to > range.x;
    cut = span.to_face;
  }
#endif
  return search;
}

// Outward normal of the faces that a section cuts, in eye space.
vec3 cut_normal(int section) {
#ifdef SECTIONS
  return -view.sections[section].xyz;
#else
  return vec3(0.0);
#endif
}

// Eye depth where a pixel's ray meets the plane of a section.
float depth_on(vec2 pixel, int section) {
  vec4 plane = view.sections[section];
  return -(dot(plane.xyz, eye_point(pixel, 0.0)) + plane.w) / dot(plane.xyz, eye_direction(pixel));
}

#ifdef SECTIONS
// How much nearer than the plane cut faces are, in the roundings of a float depth: than any face in the plane.
const float kNearerCut = 8.0 / 16777216.0;

// Eye depth of a cut face on a pixel's ray.
float cut_depth(vec2 pixel, int section) {
  float depth = depth_on(pixel, section);
  float slope = dot(view.sections[section].xyz, eye_direction(pixel));
  return max(depth - kNearerCut * size_of(eye_point(pixel, depth)) / slope, view.depth_range.x);
}

// Whether the kept part of a pixel's ray begins on a section plane between the near and far plane, and on which.
bool begins_cut(vec2 pixel, out int cut) {
  vec4 values[2];
  section_values(Pair3(eye_point(pixel, 0.0), vec3(0.0)), vec3(0.0), 0.0, values);
  Search search = search_kept(0.0, eye_direction(pixel), values, 0u, cut);
  return (search.cut_second && search.second.x <= search.second.y) || (search.cut_first && search.first.x <= search.first.y);
}
#endif
