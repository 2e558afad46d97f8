// Which points the section planes keep: a little more than their half-spaces, namely what lies in a plane up to
// rounding. So a face in the plane is whole, and is no cut. See core/internal/section_rounding.h.
#include "view.glsl"
#include "pairs.glsl"

float size_of(vec3 p) { return abs(p.x) + abs(p.y) + abs(p.z); }

#ifdef SECTIONS
// The rounding as a share of the sum of the absolute coordinates that a point is computed from, but for its distance from the eye: of the item
// in its chunk, and of the point in the item. Placing it and evaluating a plane there take some 25 roundings of at most
// 2^-24 of that each. The rest of the 32 keeps values positive that are interpolated between corners in the plane.
const float kSectionRounding = 32.0 / 16777216.0;

// The rounding as a share of coordinates relative to the eye, which are pairs of floats.
const float kPairRounding = 1.0 / 1073741824.0;

// The value of a section plane at a point.
float section_value_at(int i, Pair3 p) {
  Pair3 terms = pair_product(p, Pair3(view.sections[i].xyz, view.sections_rest[i].xyz));
  return pair_total(terms, view.sections[i].w, view.sections_rest[i].w);
}

// The values of all section planes at p + `beside`, which they keep where theirs are not negative. `size`: see
// kSectionRounding.
void section_values(Pair3 p, vec3 beside, float size, out vec4 values[2]) {
  values = vec4[2](vec4(0.0), vec4(0.0));
  float margin =
      kSectionRounding * (size + size_of(beside)) + kPairRounding * size_of(p.high) + view.depth_range.z;
  for (int i = 0; i < view.flags.y; ++i)
    values[i >> 2][i & 3] = section_value_at(i, p) + dot(view.sections[i].xyz, beside) + margin;
}

bool sections_keep(vec4 values[2]) {
  bool unite = view.flags.z == 1;
  for (int i = 0; i < view.flags.y; ++i)
    if ((values[i >> 2][i & 3] >= 0.0) == unite) return unite;
  return !unite;
}
#endif
