// Darkens what lies in corners and behind edges, and draws lines along them, by depth alone: a factor for each pixel.
//
// Reverse-Z depth is an affine function of the pixel on any plane, in perspective and parallel views alike. So the sum
// of the steps to two opposite neighbours is 0 on planes, above 0 in corners and behind edges, and below 0 on ridges.
// Steps are measured in pixels, that is in the width of a pixel at the surface: slopes, whatever the view.
layout(location = 0) uniform ivec2 corner;  // of the image in the framebuffer, pixels
layout(location = 2) uniform int linear_colour;
layout(location = 3) uniform vec2 pixel_depth;  // of a step of one pixel, as an affine function of depth: factor, offset
layout(location = 4) uniform float shading;     // 0 … 1
layout(location = 5) uniform float lines;       // 0 … 1

#ifdef SAMPLES
layout(binding = 0) uniform sampler2DMS depths;
#define SIZE textureSize(depths)
#else
layout(binding = 0) uniform sampler2D depths;
#define SIZE textureSize(depths, 0)
#endif

layout(location = 0) out vec4 factor;

const ivec2 kAxes[4] = ivec2[](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(1, -1));
const ivec2 kWideAxes[4] = ivec2[](ivec2(5, 2), ivec2(2, 5), ivec2(-2, 5), ivec2(-5, 2));
const float kWide = 5.4;           // their length, pixels
const float kSteepest = 4.0;       // slope of a surface whose creases are drawn; what is steeper is a rounded outline
const float kJump = 12.0;          // slope from which on a surface ends
const vec2 kCrease = vec2(0.7, 1.4);  // change of slope: where lines begin, and where they are full
const float kFine = 0.2;              // of a line where another one lies within three pixels
const int kThin = 4;                  // pixels

float depth_at(ivec2 place) {
  return texelFetch(depths, clamp(place, ivec2(0), SIZE - 1), 0).r;  // the first sample stands for the pixel
}

bool inside(ivec2 place) { return all(greaterThanEqual(place, ivec2(0))) && all(lessThan(place, SIZE)); }

// Differences of depth to two opposite neighbours; none at the image's border, where one of them is missing.
vec2 steps(ivec2 place, ivec2 axis, float here) {
  if (!inside(place + axis) || !inside(place - axis)) return vec2(0.0);
  return vec2(depth_at(place + axis), depth_at(place - axis)) - here;
}

// 0 on planes, towards 1 in corners and behind edges.
float hollow(float slope_sum) {
  float h = max(0.0, slope_sum);
  return h / (1.0 + h);
}

// How strong a line is: fainter where slopes change as much two pixels off, so that lines do not blacken detail that is
// hardly wider than they are, or run along rods that are round within few pixels. `change`: of slope, of the line.
float alone(ivec2 place, ivec2 axis, float here, float to_slope, float change) {
  float other = 0.0;
  for (int side = -1; side <= 1; side += 2) {
    ivec2 beside = place + 2 * side * axis;
    vec2 around = steps(beside, axis, depth_at(beside));
    other = max(other, abs(around.x + around.y) * to_slope);
  }
  return mix(1.0, kFine, smoothstep(0.5, 1.0, other / min(abs(change), 2.0 * kJump)));
}

// How strong an outline is where nothing is drawn: fainter beside what is thin.
float outline(ivec2 place) {
  float drawn = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 towards = (i < 2 ? 1 : -1) * kAxes[i & 1];
    if (depth_at(place + towards) > 0.0) drawn = max(drawn, depth_at(place + kThin * towards) > 0.0 ? 1.0 : kFine);
  }
  return drawn;
}

void main() {
  ivec2 place = ivec2(gl_FragCoord.xy) - corner;
  float here = depth_at(place);
  if (here == 0.0) {  // nothing is drawn here: only outlines
    float drawn = lines > 0.0 ? outline(place) : 0.0;
    if (drawn == 0.0) discard;
    factor = vec4(vec3(1.0 - lines * drawn), 1.0);
    return;
  }
  float per_pixel = 1.0 / (pixel_depth.x * here + pixel_depth.y);
  float line = 0.0, dark = 0.0;
  for (int i = 0; i < 4; ++i) {
    float reach = i < 2 ? 1.0 : 1.41421356;
    vec2 slopes = steps(place, kAxes[i], here) * per_pixel / reach;
    float change = slopes.x + slopes.y;
    bool gap = min(slopes.x, slopes.y) > kJump;  // a pixel between two surfaces: detail too fine to be shaded
    dark += gap ? 0.0 : hollow(change);
    float drawn = 0.0;
    if (max(slopes.x, slopes.y) > kJump && abs(min(slopes.x, slopes.y)) < kSteepest)
      drawn = 1.0;  // on a surface that begins behind another one
    else if (max(abs(slopes.x), abs(slopes.y)) < kSteepest)
      drawn = smoothstep(kCrease.x, kCrease.y, abs(change));
    if (lines > 0.0 && drawn > line) line = max(line, drawn * alone(place, kAxes[i], here, per_pixel / reach, change));
  }
  if (shading > 0.0)
    for (int i = 0; i < 4; ++i) {
      vec2 wide = steps(place, kWideAxes[i], here);
      dark += hollow((wide.x + wide.y) * per_pixel / kWide);
    }
  factor = vec4(vec3((1.0 - shading * dark / 8.0) * (1.0 - lines * line)), 1.0);
}
