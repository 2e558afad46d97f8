// Sums and products of floats with their rounding errors, for what cancels. All `precise`: a compiler that reorders or contracts
// would lose them. Dekker, "A Floating-Point Technique for Extending the Available Precision", Numer. Math. 18 (1971); Knuth, "The Art
// of Computer Programming", volume 2, 4.2.2. No fma: GLSL does not promise that it rounds once.

// x holds the value, y what is missing.
vec2 exact_sum(float a, float b) {
  precise float s = a + b;
  precise float t = s - a;
  precise float u = s - t;
  precise float v = a - u;
  precise float w = b - t;
  precise float e = v + w;
  return vec2(s, e);
}

// The upper twelve bits of a float's 24; the rest is exact, too. By its bits: no product that a compiler may fold away.
float upper_half(float a) { return uintBitsToFloat(floatBitsToUint(a) & 0xfffff000u); }

vec2 exact_product(float a, float b) {
  float ah = upper_half(a), bh = upper_half(b);
  precise float al = a - ah, bl = b - bh;
  precise float p = a * b;
  precise float hh = ah * bh;
  precise float e1 = hh - p;
  precise float hl = ah * bl;
  precise float e2 = e1 + hl;
  precise float lh = al * bh;
  precise float e3 = e2 + lh;
  precise float ll = al * bl;
  precise float e = e3 + ll;
  return vec2(p, e);
}

vec2 add(vec2 a, vec2 b) {
  vec2 s = exact_sum(a.x, b.x);
  precise float low = a.y + b.y;
  precise float e = s.y + low;
  return exact_sum(s.x, e);
}

vec2 subtract(vec2 a, vec2 b) { return add(a, -b); }

vec2 multiply(vec2 a, vec2 b) {
  vec2 p = exact_product(a.x, b.x);
  precise float c1 = a.x * b.y;
  precise float c2 = a.y * b.x;
  precise float c = c1 + c2;
  precise float e = p.y + c;
  return exact_sum(p.x, e);
}

// a.x b.y - a.y b.x
vec2 exact_cross(vec2 a, vec2 b) { return subtract(exact_product(a.x, b.y), exact_product(a.y, b.x)); }

float cross_product(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

// |v|^2 - c^2, where c may come close to |v|.
float difference_of_squares(vec2 vx, vec2 vy, vec2 c) {
  return subtract(add(multiply(vx, vx), multiply(vy, vy)), multiply(c, c)).x;
}

// Where a discriminant is smaller than this part of its terms, it is taken again without rounding errors: at silhouettes, a few
// pixels of many.
const float kCancels = 0.02;
