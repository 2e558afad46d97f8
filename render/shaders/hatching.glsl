// Hatching of cut faces, as drawing offices do it: lines at 45 degrees that lie still in the section plane. Their
// distance is a power of two of metres along the plane's coordinates, between one and two of the least distance in the
// image. Where they come too near to each other every second line fades. Needs kept_ray.glsl. HATCHING: compiled for
// images that have it, since a branch alone would cost a tenth of an image on a CPU.

const float kFadeRange = 0.3;         // in powers of two of the distance
const int kLeastPower = -24, kMostPower = 19;  // of metres; half of kHatchPeriod

// Share of the pixel that lines cover, times their strength. `id`: items whose ids are neighbours differ in the
// direction of their lines or in their place.
float hatch_cover(vec2 pixel, int section, uint id) {
#ifdef HATCHING
  uint kind = ((id * 0x9e3779b1u >> 16) * 6u) >> 16;  // by the golden ratio: the next id is two kinds away or more
  int direction = int(kind / 3u);
  vec4 across = view.hatch_across[2 * section + direction], plane = view.sections[section];
  vec3 start = eye_point(pixel, 0.0), ray = eye_direction(pixel);
  float slope = dot(plane.xyz, ray), t = depth_on(pixel, section);
  vec3 right = eye_step(vec2(1.0, 0.0), t), up = eye_step(vec2(0.0, 1.0), t);
  right -= ray * (dot(plane.xyz, right) / slope);  // steps of a pixel in the plane
  up -= ray * (dot(plane.xyz, up) / slope);
  float metres = length(vec2(dot(across.xyz, right), dot(across.xyz, up)));  // of a pixel
  float level = log2(metres * view.hatching.y);
  if (!(level < float(kMostPower))) return 0.0;  // seen edge-on
  int power = max(int(ceil(level)), kLeastPower);
  float wide = ldexp(1.0, power);
  // Every second line is a line of the next power, also where items shift them by a third or two of their distance.
  uint third = kind % 3u;
  float shift = third == 0u ? 0.0 : 2.0 / 3.0 * ((third == 1u) == ((power & 1) == 0) ? 2.0 : 1.0);
  float place = (dot(across.xyz, start + t * ray) + across.w) / wide +
                2.0 * fract(0.5 * view.hatch_whole[section][direction] / wide) + shift;
  float line = round(place), off = abs(place - line) * wide / metres;
  bool second = fract(0.5 * line) != 0.0;
  float fade = second ? smoothstep(0.0, kFadeRange, float(power) - level) : 1.0;
  return view.hatching.x * fade * clamp(0.5 * view.hatching.z + 0.5 - off, 0.0, 1.0);
#else
  return 0.0;
#endif
}
