// How far a line covers a pixel; nothing where the image hides it: render/internal/edge_pass.h.
layout(location = 4) uniform float half_width;   // pixels
layout(location = 5) uniform vec4 pixel_depth;   // of a step of one pixel, as an affine function of depth: factor, offset;
                                                 // how many of them a surface may lie before a line on it; what sections
                                                 // leave beyond their planes, as a share of the distance from the eye
layout(location = 6) uniform vec2 sample_place;  // in the pixel, of the sample whose depth is read
layout(location = 7) uniform ivec2 section_count;  // and whether points need be kept by one of them alone
layout(location = 8) uniform mat4 eye_from_clip;
layout(location = 16) uniform vec4 sections[8];  // in eye space

#ifdef SAMPLES
layout(binding = 0) uniform sampler2DMS depths_of_image;
#define SIZE textureSize(depths_of_image)
#else
layout(binding = 0) uniform sampler2D depths_of_image;
#define SIZE textureSize(depths_of_image, 0)
#endif

layout(location = 0) flat in vec4 ends;
layout(location = 1) flat in vec3 depths;

layout(location = 0) out float cover;

const float kSteepest = 32.0;  // slope of a surface in pixels; what is steeper is where one ends
const vec2 kBend = vec2(0.7, 1.0);  // by how much of itself, and of pixels more, a slope may change within a pixel

const float kRound = 3.0;  // by how much more than its slope a surface may fall that turns away: to the outline of a ball

float depth_at(ivec2 place) { return texelFetch(depths_of_image, clamp(place, ivec2(0), SIZE - 1), 0).r; }

// A factor for the fall by a slope that becomes steeper towards the line's place, which lies `ahead` of the neighbour.
float turning(float slope, float next, float ahead) {
  return ahead < 0.0 && abs(slope) > 1.1 * abs(next) ? kRound : 1.0;
}

// By how much the surface falls from the pixel's depth to the line's place along an axis, with the slope to one of both
// neighbours. It is that of a surface if the next step is like it, and not where one ends.
float kindest(ivec2 pixel, ivec2 axis, float here, float from_sample, float step) {
  float least = 0.0;
  for (int side = -1; side <= 1; side += 2) {
    float beside = depth_at(pixel + side * axis), slope = beside - here, next = depth_at(pixel + 2 * side * axis) - beside;
    if (abs(slope) <= kSteepest * step && abs(next - slope) <= kBend.x * abs(slope) + kBend.y * step)
      least = min(least, float(side) * slope * from_sample * turning(slope, next, float(side) * from_sample));
  }
  return least;
}

bool hidden(ivec2 pixel, vec2 place, float depth) {
  float here = depth_at(pixel), step = pixel_depth.x * depth + pixel_depth.y, reach = depth + pixel_depth.z * step;
  if (here <= reach) return false;
  if (here > reach + kRound * kSteepest * step) return true;
  vec2 from_sample = place - vec2(pixel) - sample_place;
  here += kindest(pixel, ivec2(1, 0), here, from_sample.x, step) + kindest(pixel, ivec2(0, 1), here, from_sample.y, step);
  return here > reach;
}

// Share of the four pixels around a point, the nearer ones counting more, that do not hide it. So lines that come to lie
// behind something fade within a pixel, and those along an outline are not dashed.
float visible(vec2 place, float depth) {
  ivec2 first = ivec2(floor(place - sample_place));
  vec2 share = place - sample_place - vec2(first);
  float found = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 corner = ivec2(i & 1, i >> 1);
    vec2 weight = mix(1.0 - share, share, vec2(corner));
    ivec2 pixel = clamp(first + corner, ivec2(0), SIZE - 1);
    if (!hidden(pixel, place, depth)) found += weight.x * weight.y;
  }
  return smoothstep(0.3, 0.7, found);
}

bool cut_away(vec2 place, float depth) {
  if (section_count.x == 0) return false;
  vec4 eye = eye_from_clip * vec4(place / vec2(SIZE) * 2.0 - 1.0, depth, 1.0);
  bool unite = section_count.y == 1;
  // A line in the plane belongs to what is kept, as a face in it does.
  float margin = pixel_depth.w * length(eye.xyz / eye.w);
  for (int i = 0; i < section_count.x; ++i)
    if ((dot(sections[i].xyz, eye.xyz / eye.w) + sections[i].w >= -margin) == unite) return !unite;
  return unite;
}

void main() {
  vec2 along = ends.zw - ends.xy;
  float square = dot(along, along);
  float share = square > 0.0 ? clamp(dot(gl_FragCoord.xy - ends.xy, along) / square, 0.0, 1.0) : 0.0;
  vec2 place = mix(ends.xy, ends.zw, share);
  float depth = mix(depths.x, depths.y, share);
  cover = depths.z * clamp(half_width + 0.5 - distance(gl_FragCoord.xy, place), 0.0, 1.0);
  if (cover == 0.0 || !(depth > 0.0) || cut_away(place, depth)) discard;
  cover *= visible(place, depth);
}
