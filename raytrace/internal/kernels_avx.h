// Internal: what the kernels for AVX2 and AVX-512 share: eight lanes are one register of 256 bits. Static: each is
// compiled for its own instruction set.
#pragma once

#include <immintrin.h>

#include "sightline/raytrace/internal/kernels_impl.h"

namespace sightline::raytrace {
namespace {

struct Float8 {
  __m256 v;
  static Float8 load(const float* p) { return {_mm256_load_ps(p)}; }
  static Float8 spread(float x) { return {_mm256_set1_ps(x)}; }
  void store(float* p) const { _mm256_storeu_ps(p, v); }
};
inline Float8 operator+(Float8 x, Float8 y) {
  return {_mm256_add_ps(x.v, y.v)};
}
inline Float8 operator-(Float8 x, Float8 y) {
  return {_mm256_sub_ps(x.v, y.v)};
}
inline Float8 operator*(Float8 x, Float8 y) {
  return {_mm256_mul_ps(x.v, y.v)};
}
inline Float8 operator/(Float8 x, Float8 y) {
  return {_mm256_div_ps(x.v, y.v)};
}
inline Float8 most(Float8 x, Float8 y) {
  return {_mm256_max_ps(x.v, y.v)};
}
inline Float8 least(Float8 x, Float8 y) {
  return {_mm256_min_ps(x.v, y.v)};
}
inline Float8 magnitude(Float8 x) {
  return {_mm256_andnot_ps(_mm256_set1_ps(-0.0f), x.v)};
}
inline unsigned at_most(Float8 x, Float8 y) {
  return unsigned(_mm256_movemask_ps(_mm256_cmp_ps(x.v, y.v, _CMP_LE_OQ)));
}
inline unsigned less(Float8 x, Float8 y) {
  return unsigned(_mm256_movemask_ps(_mm256_cmp_ps(x.v, y.v, _CMP_LT_OQ)));
}
inline unsigned equal(Float8 x, Float8 y) {
  return unsigned(_mm256_movemask_ps(_mm256_cmp_ps(x.v, y.v, _CMP_EQ_OQ)));
}

using Avx2 = BlockForm<Float8>;

}  // namespace
}  // namespace sightline::raytrace
