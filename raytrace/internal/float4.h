// Four floats in one register, for code of every processor.
#pragma once

#include <cstdint>

#if defined(__SSE2__) || defined(_M_X64)
#include <emmintrin.h>
#define SIGHTLINE_SSE2 1
#endif

namespace sightline::raytrace {

#if SIGHTLINE_SSE2
struct Float4 {
  __m128 v;
  static Float4 load(const float* a) { return {_mm_loadu_ps(a)}; }
  static Float4 spread(float a) { return {_mm_set1_ps(a)}; }
  void store(float* out) const { _mm_storeu_ps(out, v); }
  /// The first three; the fourth becomes 0.
  Float4 three() const { return {_mm_and_ps(v, _mm_castsi128_ps(_mm_setr_epi32(-1, -1, -1, 0)))}; }
  /// Truncated, and at most `most`.
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
inline Float4 least(Float4 a, Float4 b) {
  return {_mm_min_ps(a.v, b.v)};
}
inline Float4 most(Float4 a, Float4 b) {
  return {_mm_max_ps(a.v, b.v)};
}
#else
struct Float4 {
  float v[4];
  static Float4 load(const float* a) { return {{a[0], a[1], a[2], a[3]}}; }
  static Float4 spread(float a) { return {{a, a, a, a}}; }
  void store(float* out) const {
    for (int i = 0; i < 4; ++i) out[i] = v[i];
  }
  Float4 three() const { return {{v[0], v[1], v[2], 0.0f}}; }
  void store_whole(std::int32_t* out) const {
    for (int i = 0; i < 4; ++i) out[i] = std::int32_t(v[i]);
  }
};
template <class Op>
Float4 each(Float4 a, Float4 b, Op op) {
  return {{op(a.v[0], b.v[0]), op(a.v[1], b.v[1]), op(a.v[2], b.v[2]), op(a.v[3], b.v[3])}};
}
inline Float4 operator+(Float4 a, Float4 b) {
  return each(a, b, [](float x, float y) { return x + y; });
}
inline Float4 operator-(Float4 a, Float4 b) {
  return each(a, b, [](float x, float y) { return x - y; });
}
inline Float4 operator*(Float4 a, Float4 b) {
  return each(a, b, [](float x, float y) { return x * y; });
}
inline Float4 least(Float4 a, Float4 b) {
  return each(a, b, [](float x, float y) { return x < y ? x : y; });
}
inline Float4 most(Float4 a, Float4 b) {
  return each(a, b, [](float x, float y) { return x > y ? x : y; });
}
#endif

}  // namespace sightline::raytrace
