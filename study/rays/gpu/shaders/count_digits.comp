// How many pairs of each run have each digit.
#include "digits.glsl"

void main() {
  uint run = invocation();
  if (run >= count) return;
  uint found[kDigits];
  for (uint d = 0u; d < kDigits; ++d) found[d] = 0u;
  for (uint k = run * kRun; k < min((run + 1u) * kRun, pair_count); ++k) ++found[digit_of(pairs[k].x)];
  for (uint d = 0u; d < kDigits; ++d) places[d * count + run] = found[d];
}
