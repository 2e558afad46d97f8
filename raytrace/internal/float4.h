// Four floats in one register, for code of every processor.
#pragma once

#include <cstdint>

#if defined(__SSE2__) || defined(_M_X64)
#include <emmintrin.h>
#define SIGHTLINE_SSE2 1
#else
#include "sightline/raytrace/internal/lanes.h"
#endif

namespace sightline::raytrace {

#if SIGHTLINE_SSE2
struct Float4 {
  __m128 v;
  static Float4 load(const float* a) { return {_mm_loadu_ps(a)}; }
  static Float4 spread(float a) { return {_mm_set1_ps(a)}; }
  static Float4 of(double x, double y, double z) {
    const __m128 w = _mm_setzero_ps();
    return {_mm_movelh_ps(_mm_cvtpd_ps(_mm_setr_pd(x, y)), _mm_unpacklo_ps(_mm_cvtsd_ss(w, _mm_set_sd(z)), w))};
  }
  void store(float* out) const { _mm_storeu_ps(out, v); }
  /// The first three; the fourth becomes 0.
  Float4 three() const { return {_mm_and_ps(v, _mm_castsi128_ps(_mm_setr_epi32(-1, -1, -1, 0)))}; }
  /// Truncated.
  void store_whole(std::int32_t* out) const { _mm_storeu_si128(reinterpret_cast<__m128i*>(out), _mm_cvttps_epi32(v)); }
};
inline Float4 operator+(Float4 a, Float4 b) {
  return {_mm_add_ps(a.v, b.v)};
}
inline Float4 operator-(Float4 a, Float4 b) {
  return {_mm_sub_ps(a.v, b.v)};
}
inline Float4 operator*(Float4 a, Float4 b) {
  return {_mm_mul_ps(a.v, b.v)};
}
inline Float4 operator/(Float4 a, Float4 b) {
  return {_mm_div_ps(a.v, b.v)};
}
inline Float4 magnitude(Float4 a) {
  return {_mm_andnot_ps(_mm_set1_ps(-0.0f), a.v)};
}
/// Magnitudes of a with the signs of b; a must not have any.
inline Float4 with_signs(Float4 a, Float4 b) {
  return {_mm_or_ps(a.v, _mm_and_ps(_mm_set1_ps(-0.0f), b.v))};
}
/// A bit per sign.
inline unsigned signs(Float4 a) {
  return unsigned(_mm_movemask_ps(a.v));
}
inline Float4 least(Float4 a, Float4 b) {
  return {_mm_min_ps(a.v, b.v)};
}
inline Float4 most(Float4 a, Float4 b) {
  return {_mm_max_ps(a.v, b.v)};
}
#else
struct Float4 : Lanes<float, 4> {
  Float4() = default;
  Float4(const Lanes<float, 4>& lanes) : Lanes(lanes) {}
  static Float4 of(double x, double y, double z) {
    const float numbers[] = {float(x), float(y), float(z), 0.0f};
    return load(numbers);
  }
  Float4 three() const { return of(v[0], v[1], v[2]); }
  void store_whole(std::int32_t* out) const {
    for (int i = 0; i < 4; ++i) out[i] = std::int32_t(v[i]);
  }
};
#endif

}  // namespace sightline::raytrace
