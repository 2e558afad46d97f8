// A pixel's ray in eye space, with eye depth as its parameter t, and the parts of it that the near plane, the far plane
// and the section planes keep.
#include "view.glsl"
#include "search.glsl"

vec3 eye_direction(vec2 pixel) {
  return vec3(view.pixel_ray[0].z + view.pixel_ray[0].w * pixel.x,
              view.pixel_ray[1].z + view.pixel_ray[1].w * pixel.y, -1.0);
}

vec3 eye_point(vec2 pixel, float t) {
  vec2 start = vec2(view.pixel_ray[0].x + view.pixel_ray[0].y * pixel.x,
                    view.pixel_ray[1].x + view.pixel_ray[1].y * pixel.y);
  return vec3(start, 0.0) + t * eye_direction(pixel);
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
// `cut`: the section whose face cut solids show. Compiled without SECTIONS for views that have none.
Search search_kept(vec3 start, vec3 direction, uint hidden, out int cut) {
  vec2 range = view.depth_range.xy + start.z;  // start.z is minus the depth of t = 0
  Search search = search_within(range, hidden);
  cut = 0;
#ifdef SECTIONS
  int count = view.flags.y;
  bool unite = view.flags.z == 1;
  Span span = whole_line();  // faces: index of the section
  for (int i = 0; i < count; ++i) {
    vec4 section = unite ? -view.sections[i] : view.sections[i];
    clip(span, dot(section.xyz, start) + section.w, dot(section.xyz, direction), i);
  }
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
// Eye depth, between the near and far plane, where the kept part begins on a pixel's ray; kNoHit where it does not.
float section_entry(vec2 pixel, out int cut) {
  Search search = search_kept(eye_point(pixel, 0.0), eye_direction(pixel), 0u, cut);
  if (search.cut_second && search.second.x <= search.second.y) return search.second.x;
  return search.cut_first && search.first.x <= search.first.y ? search.first.x : kNoHit;
}
#endif
