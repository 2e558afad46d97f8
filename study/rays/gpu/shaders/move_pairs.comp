// Moves each pair to its place.
#include "digits.glsl"

layout(std430, binding = 2) writeonly restrict buffer Sorted {
  uvec2 sorted[];
};

void main() {
  uint run = invocation();
  if (run >= count) return;
  uint place[kDigits];
  for (uint d = 0u; d < kDigits; ++d) place[d] = places[d * count + run];
  for (uint k = run * kRun; k < min((run + 1u) * kRun, pair_count); ++k) {
    uvec2 pair = pairs[k];
    sorted[place[digit_of(pair.x)]++] = pair;
  }
}
