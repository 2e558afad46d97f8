// Internal: the kernels of depth images over any instruction set, a row at a time.
#pragma once

#include "sightline/culling/occlusion/internal/kernels.h"

namespace sightline::culling {

/// OcclusionKernels::distances: the reciprocal of the greatest one, or its negative where the view is not perspective.
template <class Simd>
void distances(const float* const* reciprocal_depth, int images, bool perspective, int count, float* out) {
  using Lanes = typename Simd::Lanes;
  constexpr float kUp = 1.0f + 0x1p-22f;  // more than what rounding takes
  int done = 0;
  for (; done + kLanes <= count; done += kLanes) {
    Lanes nearest = Simd::load(reciprocal_depth[0] + done);
    for (int i = 1; i < images; ++i) nearest = Simd::most(nearest, Simd::load(reciprocal_depth[i] + done));
    Simd::store(out + done,
                perspective ? Simd::divide(Simd::spread(kUp), nearest) : Simd::multiply(Simd::spread(-1.0f), nearest));
  }
  for (; done < count; ++done) {
    float nearest = reciprocal_depth[0][done];
    for (int i = 1; i < images; ++i)
      nearest = nearest < reciprocal_depth[i][done] ? reciprocal_depth[i][done] : nearest;
    out[done] = perspective ? kUp / nearest : -1.0f * nearest;
  }
}

/// See OcclusionKernels::coarser_row.
template <class Simd>
void coarser_row(const float* low, const float* high, int width, float* out) {
  const auto greater = [](float a, float b) { return a < b ? b : a; };
  const int pairs = width / 2;
  int done = 0;
  for (; done + kLanes <= pairs; done += kLanes) {
    const float *a = low + 2 * done, *b = high + 2 * done;
    Simd::store(out + done, Simd::most_of_pairs(Simd::most(Simd::load(a), Simd::load(b)),
                                                Simd::most(Simd::load(a + kLanes), Simd::load(b + kLanes))));
  }
  for (; done < pairs; ++done) {
    const float *a = low + 2 * done, *b = high + 2 * done;
    out[done] = greater(greater(a[0], a[1]), greater(b[0], b[1]));
  }
  if (width % 2 == 1) out[pairs] = greater(low[width - 1], high[width - 1]);
}

}  // namespace sightline::culling
