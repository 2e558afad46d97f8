// Colour and id of a surface point. Light: a head-light or lights far away (gpuprims/surroundings.h), and a hemisphere of sky.

layout(binding = 2) uniform samplerBuffer materials;  // rgb: sRGB colour, a: alpha

// GHOST: faint surfaces, which render/internal/overlays.h puts over the image. BLENDED: what is summed up of
// transparent surfaces, in any order. Without either: the image itself.
#ifdef BLENDED
layout(location = 0) out vec4 out_sum;         // colour * alpha, alpha, times the weight
layout(location = 1) out float out_let_pass;   // share of the light from behind; blending multiplies it
layout(location = 2) out float out_nearest;    // reverse-Z; blending takes the largest
layout(location = 64) uniform vec2 blend_range;  // eye depths of the nearest surface and of the farthest
#else
layout(location = 0) out vec4 out_colour;
#ifndef GL_ES
layout(location = 1) out uint out_id;  // item id + 1; 0 is background
#endif
#ifdef NORMALS
layout(location = 2) out vec4 out_normal;  // in eye space, towards the eye
#endif
#endif
#ifndef SURFACE_DEPTH
#define SURFACE_DEPTH gl_FragCoord.z
#endif

const vec3 kLuma = vec3(0.299, 0.587, 0.114);  // Rec. 601
const float kDarkFace = 0.3;

vec4 material_of(uint word) { return texelFetch(materials, int(word & kMaterialMask)); }

// Screen-door transparency: needs no sorting, and every pixel shows exactly one item. The 4x4 pattern shifts from item
// to item, so that transparent surfaces behind each other all show.
bool dithered_away(uint word, uint id) {
  float alpha = material_of(word).a;
  if (alpha >= 1.0) return false;
#if defined(GHOST) || defined(BLENDED)
  return alpha <= 0.0;
#endif
  uvec2 pixel = uvec2(gl_FragCoord.xy) + uvec2(id * 7u, id * 3u);
  uint across = pixel.x ^ pixel.y;
  // Bayer's matrix of order 4: the bits of x ^ y and of y alternate, the lowest first.
  uint rank = (across & 1u) << 3 | (pixel.y & 1u) << 2 | (across & 2u) | (pixel.y & 2u) >> 1;
  return alpha < (float(rank) + 0.5) / 16.0;
}

// Weighted blended transparency (McGuire and Bavoil, "Weighted Blended Order-Independent Transparency", 2013): near
// surfaces weigh more than those that they cover. The weight falls by kFall powers of two over the range of depths.
#ifdef BLENDED
const float kFall = 12.0;

float weight_of(float depth) {
  mat4 clip = view.clip_from_eye;
  float distance = (clip[3][2] - depth * clip[3][3]) / (clip[2][2] - depth * clip[2][3]);
  float place = (distance - blend_range.x) / max(blend_range.y - blend_range.x, 1e-6 * blend_range.y);
  return exp2(4.0 - kFall * clamp(place, 0.0, 1.0));
}
#endif

float power_24(float x) {
  float square = x * x, eighth = square * square * square * square;
  return eighth * eighth * eighth;
}

// How much of a ghost shows: more where it is seen edge-on, as its outline.
float ghost_alpha(float alpha, float head) {
  float edge = 1.0 - head;
  return alpha * (0.12 + 0.88 * edge * edge);
}

// What all lights give: x: the sum of the cosines, y: that of their gloss, each times the light's strength.
vec2 light_on(vec3 n, vec3 to_viewer, float head) {
  if (view.lights[0].w == 0.0) return vec2(head, power_24(head));
  vec2 sum = vec2(0.0);
  for (int i = 0; i < 2; ++i) {
    vec4 light = view.lights[i];
    float cosine = dot(n, light.xyz);
    if (light.w == 0.0 || cosine <= 0.0) continue;
    sum += light.w * vec2(cosine, power_24(max(0.0, dot(n, normalize(light.xyz + to_viewer)))));
  }
  return sum;
}

// Lights a surface that faces `n`, with the mean of the head-light's cosine, of what light_on() gives and of the sky's
// share over what is shown. `hatch`: share of the pixel that lines cover, dark on light faces and light on dark ones.
void write_lit(vec3 n, float head, vec2 lights, float sky, float hatch, uint word, uint id) {
  float light = 0.30 + 0.50 * lights.x + 0.25 * sky;
  vec4 material = material_of(word);
  float dark = 1.0 - max(max(material.r, material.g), material.b), square = dark * dark;
  vec3 colour = material.rgb + view.up.w * square * square;  // twin: gpuprims/internal/studio_black.h
  vec3 lit = min(colour * light + 0.12 * lights.y, vec3(1.0));
#ifdef HATCHING
  lit = mix(lit, vec3(dot(lit, kLuma) < kDarkFace ? 1.0 : 0.0), hatch);
#endif
#ifdef BLENDED
  out_sum = vec4(lit * material.a, material.a) * weight_of(SURFACE_DEPTH);
  out_let_pass = 1.0 - material.a;
  out_nearest = SURFACE_DEPTH;
#else
#ifdef GHOST
  float shown = ghost_alpha(material.a, head);
  out_colour = vec4(lit * (head * shown), shown);  // darker edge-on, so that it shows on any background
#else
  out_colour = vec4(lit, 1.0);
#endif
#ifndef GL_ES
  out_id = id + 1u;
#endif
#ifdef NORMALS
  out_normal = vec4(n, 0.0);
#endif
#endif
}

void write_surface(vec3 normal, vec3 direction, float hatch, uint word, uint id) {
  vec3 to_viewer = normalize(-direction);
  float square = dot(normal, normal);
  vec3 n = square > 0.0 && square < 3.0e38 ? normal * inversesqrt(square) : to_viewer;
  if (dot(n, to_viewer) < 0.0) n = -n;  // both sides are lit: open pipes and cut solids show their inside
  float head = dot(n, to_viewer);
  write_lit(n, head, light_on(n, to_viewer, head), 0.5 + 0.5 * dot(n, view.up.xyz), hatch, word, id);
}

// The mean of light_on() over the disc that a ball shows. Of a light at the angle a from the viewer, the cosine's mean is
// 2 / 3 (sin a + (pi - a) cos a) / pi: the phase function of a Lambertian sphere. That of the gloss, a power of 24 about
// the direction halfway to the viewer, is the cosine of that half angle / 13.
vec2 mean_light(vec3 to_viewer) {
  if (view.lights[0].w == 0.0) return vec2(2.0 / 3.0, 1.0 / 13.0);
  vec2 sum = vec2(0.0);
  for (int i = 0; i < 2; ++i) {
    float cosine = clamp(dot(to_viewer, view.lights[i].xyz), -1.0, 1.0), angle = acos(cosine);
    float diffuse = (sin(angle) + (3.14159265 - angle) * cosine) * (2.0 / 3.0 / 3.14159265);
    sum += view.lights[i].w * vec2(diffuse, cos(0.5 * angle) / 13.0);
  }
  return sum;
}

// One colour for a solid that is too small to show its shape: the mean over the disc that a ball shows. There the mean
// of the head-light's cosine is 2 / 3, and that of the normal is 2 / 3 of the direction to the viewer.
void write_mean_surface(vec3 direction, uint word, uint id) {
  vec3 to_viewer = normalize(-direction);
  write_lit(to_viewer, 2.0 / 3.0, mean_light(to_viewer), 0.5 + dot(to_viewer, view.up.xyz) / 3.0, 0.0, word, id);
}
