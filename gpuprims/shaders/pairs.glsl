// Numbers as sums of two floats: about 46 bits, without double precision, which many GPUs have not or only at a small
// part of the speed. Dekker, "A Floating-Point Technique for Extending the Available Precision", Numerische Mathematik
// 18 (1971); Knuth, "The Art of Computer Programming", volume 2, section 4.2.2. The low part is what rounding took from
// the high one. Sums let it grow by a few ulps of that. All by components.

struct Pair3 {
  vec3 high, low;
};

// The leading 12 of 24 bits: products of two such numbers are exact, and so is the rest, which has the other 12.
vec3 leading_bits(vec3 a) { return uintBitsToFloat(floatBitsToUint(a) & 0xfffff000u); }

// GLSL ES has no `precise`. A factor of 1 that the compiler does not know keeps it from simplifying sums.
#ifdef GL_ES
uniform float one;
#define ROUNDED(sum) ((sum) * one)
#else
#define ROUNDED(sum) (sum)
#endif

// a + b, exactly.
Pair3 pair_sum(vec3 a, vec3 b) {
  precise vec3 sum = ROUNDED(a + b), of_b = ROUNDED(sum - a);
  precise vec3 lost = (a - (sum - of_b)) + (b - of_b);
  return Pair3(sum, lost);
}

Pair3 pair_sum(Pair3 a, vec3 b) {
  Pair3 sum = pair_sum(a.high, b);
  sum.low += a.low;
  return sum;
}

Pair3 pair_sum(Pair3 a, Pair3 b) {
  Pair3 sum = pair_sum(a.high, b.high);
  sum.low += a.low + b.low;
  return sum;
}

// a * b, exactly but for the last bit of the low part.
Pair3 pair_product(vec3 a, vec3 b) {
  vec3 a0 = leading_bits(a), b0 = leading_bits(b);
  precise vec3 a1 = a - a0, b1 = b - b0, product = a * b;
  precise vec3 lost = (((a0 * b0 - product) + a0 * b1) + a1 * b0) + a1 * b1;  // in this order nothing is rounded
  return Pair3(product, lost);
}

Pair3 pair_product(Pair3 a, Pair3 b) {
  Pair3 product = pair_product(a.high, b.high);
  product.low += a.high * b.low + a.low * b.high;
  return product;
}

Pair3 pair_negative(Pair3 a) { return Pair3(-a.high, -a.low); }

Pair3 pair_cross(Pair3 a, Pair3 b) {
  return pair_sum(pair_product(Pair3(a.high.yzx, a.low.yzx), Pair3(b.high.zxy, b.low.zxy)),
                  pair_negative(pair_product(Pair3(a.high.zxy, a.low.zxy), Pair3(b.high.yzx, b.low.yzx))));
}

// The sum of the three components.
float pair_total(Pair3 a) {
  Pair3 two = pair_sum(a.high.xxx, a.high.yyy), three = pair_sum(two, a.high.zzz);
  precise float total = three.high.x + (three.low.x + (a.low.x + a.low.y + a.low.z));
  return total;
}

// The sum of a vector of pairs and one more number.
float pair_total(Pair3 a, float high, float low) {
  Pair3 two = pair_sum(a.high.xxx, a.high.yyy), four = pair_sum(pair_sum(two, a.high.zzz), vec3(high));
  precise float total = four.high.x + (four.low.x + (a.low.x + a.low.y + a.low.z + low));
  return total;
}

// A matrix times a vector, good to some 34 bits of the vector's size. `leading` are the leading bits of the matrix,
// `rest` is what they leave.
Pair3 pair_transform(mat3 leading, mat3 rest, Pair3 v) {
  vec3 v0 = leading_bits(v.high);
  precise vec3 v1 = (v.high - v0) + v.low;
  precise vec3 x = leading[0] * v0.x, y = leading[1] * v0.y, z = leading[2] * v0.z;  // exact
  Pair3 sum = pair_sum(pair_sum(x, y), z);
  return pair_sum(sum.high, sum.low + (leading * v1 + rest * v.high));
}
