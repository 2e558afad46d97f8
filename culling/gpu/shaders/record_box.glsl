// An item's box from its record: the support function of its shape (core/primitive.cpp) along the axes, in the record's
// units, and margins that make up for rounding. C++ twin, and why the margins suffice: culling/gpu/record_box.h.
const float kTwoToMinus16 = 1.52587890625e-5, kTwoToMinus17 = 7.62939453125e-6, kTwoToMinus20 = 9.5367431640625e-7,
            kTwoToMinus43 = 1.13686837721616e-13;

layout(binding = 5) uniform usamplerBuffer records;       // gpuprims/packing.h
layout(binding = 6) uniform samplerBuffer chunk_origins;  // relative to that of the boxes

#if defined(SHAPE_TORUS) || defined(SHAPE_RECTANGULAR_TORUS)
#define SWEPT
const int kTexels = 5;
#elif defined(SHAPE_PYRAMID)
const int kTexels = 6;
#elif defined(SHAPE_SNOUT)
const int kTexels = 7;
#else
const int kTexels = 4;
#endif

vec4 record_floats(uint record, int texel) {
  return uintBitsToFloat(texelFetch(records, kTexels * int(record) + texel));
}

#ifdef SWEPT
// Least and greatest of dot(u, e) over the unit vectors e of a sweep: (first, 1 when closed, cosine and sine of half its angle).
vec2 sweep_extent(vec4 sweep, vec3 u) {
  float whole = length(u.xy), slack = kTwoToMinus16 * (abs(u.x) + abs(u.y)), across = abs(u.y) * sweep.w;
  if (sweep.y > 0.0) return vec2(-whole, whole);
  float side = abs(u.y) * sweep.z - slack;
  return vec2(-u.x * sweep.w >= side ? -whole : u.x * sweep.z - across, u.x * sweep.w >= side ? whole : u.x * sweep.z + across);
}
#endif

// The shape along one direction u: least and greatest dot(u, p), and the sum of absolute terms, of u with a little more.
#if defined(SHAPE_CYLINDER)
vec3 extent(uint record, float height, vec3 u, vec3 a) {
  float reach = length(u.xy) + 0.5 * height * abs(u.z);
  return vec3(-reach, reach, a.x + a.y + 0.5 * height * a.z);
}
#elif defined(SHAPE_BOX)
vec3 extent(uint record, float unused, vec3 u, vec3 a) {
  float reach = 0.5 * (abs(u.x) + abs(u.y) + abs(u.z));
  return vec3(-reach, reach, a.x + a.y + a.z);
}
#elif defined(SHAPE_CAP)
// gpuprims/shaders/sphere_cap.glsl has what a cap of height c is.
float cap_support(float c, vec3 u) {
  float all = length(u), cut = 1.0 - c;
  if (c >= 1.0) return u.z >= cut * all ? all : cut * u.z + sqrt(max(0.0, (1.0 - cut) * (1.0 + cut))) * length(u.xy);
  float fall = u.z > 0.0 ? dot(u.xy, u.xy) / (all + u.z) : all - u.z;  // |u| - u.z
  float ball_fall = 0.5 * (1.0 + c * c) * fall;                        // times c
  return c * c * all >= ball_fall ? c * u.z + ball_fall / c : length(u.xy);
}
vec3 extent(uint record, float c, vec3 u, vec3 a) {
  return vec3(-cap_support(c, -u), cap_support(c, u), 2.0 * (a.x + a.y + a.z));
}
#elif defined(SHAPE_TORUS)
vec3 extent(uint record, float tube, vec3 u, vec3 a) {
  vec4 sweep = record_floats(record, 4);  // first: larger radius
  vec2 range = sweep_extent(sweep, u);
  float disc_least = tube * length(vec2(range.x, u.z)), disc_most = tube * length(vec2(range.y, u.z));
  return vec3(min(sweep.x * range.x - disc_least, sweep.x * range.y - disc_most),
              max(sweep.x * range.x + disc_least, sweep.x * range.y + disc_most), 2.0 * (sweep.x + tube) * (a.x + a.y + a.z));
}
#elif defined(SHAPE_RECTANGULAR_TORUS)
vec3 extent(uint record, float height, vec3 u, vec3 a) {
  vec4 sweep = record_floats(record, 4);  // first: inner radius
  vec2 range = sweep_extent(sweep, u);
  float rise = 0.5 * height * abs(u.z);
  return vec3(min(range.x, sweep.x * range.x) - rise, max(range.y, sweep.x * range.y) + rise, 2.0 * (a.x + a.y) + 0.5 * height * a.z);
}
#elif defined(SHAPE_PYRAMID)
vec3 extent(uint record, float height, vec3 u, vec3 a) {
  vec4 sides = record_floats(record, 4);
  vec2 offset = record_floats(record, 5).xy;
  float lean = 0.5 * (dot(u.xy, offset) + u.z * height);
  float bottom = dot(sides.xy, abs(u.xy)), top = dot(sides.zw, abs(u.xy));
  float terms = dot(sides.xy + sides.zw + abs(offset), a.xy) + height * a.z;
  return vec3(min(-lean - bottom, lean - top), max(bottom - lean, top + lean), terms);
}
#elif defined(SHAPE_SNOUT)
// The cone's circle at height z, of a snout that has a height.
vec3 circle(vec4 ends, float height, float z, vec3 u, vec3 a) {
  float part = z / height;
  float centre = part * dot(u.xy, ends.zw) + z * u.z;
  float reach = max(0.0, ends.x + (ends.y - ends.x) * (0.5 + part)) * length(u.xy);
  float terms = abs(part) * dot(a.xy, abs(ends.zw)) + abs(z) * a.z + (ends.x + ends.y) * (2.0 + abs(part)) * (a.x + a.y);
  return vec3(centre - reach, centre + reach, 2.0 * terms);
}
vec3 extent(uint record, float height, vec3 u, vec3 a) {
  vec4 ends = record_floats(record, 4), range = record_floats(record, 6);  // both radii, offset; least and greatest z
  vec3 below = circle(ends, height, range.x, u, a), above = circle(ends, height, range.y, u, a);
  return vec3(min(below.x, above.x), max(below.yz, above.yz));
}
#endif

void record_box(uint record, out vec3 low, out vec3 high) {
  vec4 r0 = record_floats(record, 0), r1 = record_floats(record, 1), r2 = record_floats(record, 2);
  uvec4 r3 = texelFetch(records, kTexels * int(record) + 3);
  mat3 rows = transpose(mat3(r0.xyz, vec3(r0.w, r1.xy), vec3(r1.zw, r2.x)));
  vec3 chunk = texelFetch(chunk_origins, int(r3.x)).xyz, centre = chunk + r2.yzw;
  for (int i = 0; i < 3; ++i) {
    vec3 shape = extent(record, uintBitsToFloat(r3.w), rows[i], abs(rows[i]) + kTwoToMinus43);
    float margin = kTwoToMinus20 * (abs(chunk[i]) + abs(r2[i + 1])) + kTwoToMinus17 * shape.z;
    low[i] = centre[i] + shape.x - margin;
    high[i] = centre[i] + shape.y + margin;
  }
}
