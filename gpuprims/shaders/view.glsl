// The view as shaders see it: eye space, where a ray's parameter t is its eye depth. Mirrors gpuprims::ViewBlock.

#include "limits.glsl"

#ifdef GL_ES
struct ViewBlock {
#else
layout(std140, binding = 0) uniform ViewBlock {
#endif
  mat3 eye_from_world;       // linear part: directions into eye space
  mat3 eye_from_world_parts[2];  // the same to 36 bits: leading bits, and the rest of them (pairs.glsl)
  vec4 pixel_ray[2];         // x, y of the point at depth t on the ray through pixel coordinate p: (a + b p) + t (c + d p)
  vec4 pixel_ray_rest;       // what float leaves of c, d (perspective; a, b in orthographic views) of x, and of y
  mat4 clip_from_eye;       // reversed zero-to-one depth
  // x: eye depth of the near plane, y: of the far plane (infinity allowed); z: what rounds world coordinates, in metres
  vec4 depth_range;
  vec4 viewport;            // xy: size in pixels; zw: in GLSL ES, its first pixel in the window
  vec4 up;                  // world up in eye space; w: the grey as which black materials are lit
  ivec4 flags;              // x: 1 perspective, 0 orthographic; y: number of sections; z: 1 when sections unite
  vec4 sections[kMaxSections];  // eye-space half-spaces, with unit normals
  // Hatching of cut faces: x: strength, 0 none; y: least distance of lines, pixels; z: their width, pixels.
  vec4 hatching;
  // Two coordinates on each section plane, in metres, across the lines of either direction: dot(xyz, p_eye) + w, and
  // whole metres beside.
  vec4 hatch_across[2 * kMaxSections];
  vec4 hatch_whole[kMaxSections];  // xy: of the two
  // Lights far away: xyz: towards them in eye space, w: their strength, 0 none. Without any there is a head-light.
  vec4 lights[2];
  vec4 sections_rest[kMaxSections];  // what float leaves of `sections`
#ifdef GL_ES
};
uniform ViewBlock view;
#else
} view;
#endif

bool perspective_view() { return view.flags.x == 1; }
