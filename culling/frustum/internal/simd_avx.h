// Internal: functions that the lanes of AVX2 and of AVX-512 share. Static: each file is compiled for its instruction
// set.
#pragma once

#include <immintrin.h>

namespace sightline::culling {

/// Minimum and maximum of the 32 floats of a leaf, none of them NaN.
static inline float least_of_leaf(const float* a) {
  const __m256 r = _mm256_min_ps(_mm256_min_ps(_mm256_loadu_ps(a), _mm256_loadu_ps(a + 8)),
                                 _mm256_min_ps(_mm256_loadu_ps(a + 16), _mm256_loadu_ps(a + 24)));
  __m128 h = _mm_min_ps(_mm256_castps256_ps128(r), _mm256_extractf128_ps(r, 1));
  h = _mm_min_ps(h, _mm_movehl_ps(h, h));
  return _mm_cvtss_f32(_mm_min_ss(h, _mm_movehdup_ps(h)));
}
static inline float most_of_leaf(const float* a) {
  const __m256 r = _mm256_max_ps(_mm256_max_ps(_mm256_loadu_ps(a), _mm256_loadu_ps(a + 8)),
                                 _mm256_max_ps(_mm256_loadu_ps(a + 16), _mm256_loadu_ps(a + 24)));
  __m128 h = _mm_max_ps(_mm256_castps256_ps128(r), _mm256_extractf128_ps(r, 1));
  h = _mm_max_ps(h, _mm_movehl_ps(h, h));
  return _mm_cvtss_f32(_mm_max_ss(h, _mm_movehdup_ps(h)));
}

}  // namespace sightline::culling
