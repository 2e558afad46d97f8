// Adds two floats exactly, as their sum and what its rounding takes, and writes both at a place of a buffer.
layout(local_size_x = 1) in;
layout(std430, binding = 0) restrict buffer Words {
  uint words[];
};
layout(location = 0) uniform vec2 terms;
layout(location = 1) uniform uint place;

void main() {
  float a = terms.x, b = terms.y;
  precise float sum = a + b, of_b = sum - a;
  precise float lost = (a - (sum - of_b)) + (b - of_b);
  words[place] = floatBitsToUint(sum);
  words[place + 1u] = floatBitsToUint(lost);
}
