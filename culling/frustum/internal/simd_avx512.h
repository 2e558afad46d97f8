// Internal: sixteen lanes with AVX-512 (F, BW, DQ, VL), in one register. For files that are compiled for it; lies in
// the anonymous namespace of each, so that every instance of a kernel is local to its file.
#pragma once

#include <cstdint>

#include <immintrin.h>

#include "sightline/culling/frustum/frustum_test.h"
#include "sightline/culling/frustum/internal/simd_avx.h"

namespace sightline::culling {
namespace {

struct Avx512 {
  struct Plane {
    __m512 x, y, z, d, band, minus_band;
  };
  using Values = __m512;

  static Plane spread(const FloatPlane& p) {
    return {_mm512_set1_ps(p.normal[0]), _mm512_set1_ps(p.normal[1]), _mm512_set1_ps(p.normal[2]),
            _mm512_set1_ps(p.offset),    _mm512_set1_ps(p.band),      _mm512_set1_ps(-p.band)};
  }
  static Values evaluate(const Plane& p, const float* x, const float* y, const float* z) {
    const __m512 xy = _mm512_add_ps(_mm512_mul_ps(p.x, _mm512_loadu_ps(x)), _mm512_mul_ps(p.y, _mm512_loadu_ps(y)));
    return _mm512_add_ps(_mm512_add_ps(xy, _mm512_mul_ps(p.z, _mm512_loadu_ps(z))), p.d);
  }
  static unsigned below(Values s, const Plane& p) { return _mm512_cmp_ps_mask(s, p.minus_band, _CMP_LT_OQ); }
  static unsigned above(Values s, const Plane& p) { return _mm512_cmp_ps_mask(s, p.band, _CMP_GE_OQ); }
  static float least(const float* a) { return least_of_leaf(a); }
  static float most(const float* a) { return most_of_leaf(a); }
  static unsigned share(const std::uint32_t* layers, std::uint32_t mask) {
    return _mm512_test_epi32_mask(_mm512_loadu_si512(layers), _mm512_set1_epi32(int(mask)));
  }
  // Sixteen floats, for screen_boxes.h. With a mask where g++ 12 warns of its own header's unmasked form (bug 105593).
  using Lanes = __m512;
  static constexpr __mmask16 kAll = 0xffff;
  static Lanes load(const float* a) { return _mm512_loadu_ps(a); }
  static void store(float* out, const Lanes& a) { _mm512_storeu_ps(out, a); }
  static void raise(float* at, const Lanes& a, unsigned bits) {
    const __m512 old = _mm512_loadu_ps(at);
    _mm512_storeu_ps(at, _mm512_mask_max_ps(old, __mmask16(bits), a, old));
  }
  static Lanes spread(float a) { return _mm512_set1_ps(a); }
  static Lanes ramp() { return _mm512_setr_ps(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15); }
  static Lanes add(const Lanes& a, const Lanes& b) { return _mm512_add_ps(a, b); }
  static Lanes subtract(const Lanes& a, const Lanes& b) { return _mm512_sub_ps(a, b); }
  static Lanes multiply(const Lanes& a, const Lanes& b) { return _mm512_mul_ps(a, b); }
  static Lanes divide(const Lanes& a, const Lanes& b) { return _mm512_div_ps(a, b); }
  static Lanes root(const Lanes& a) { return _mm512_maskz_sqrt_ps(kAll, a); }
  static Lanes least(const Lanes& a, const Lanes& b) { return _mm512_maskz_min_ps(kAll, a, b); }
  static Lanes most(const Lanes& a, const Lanes& b) { return _mm512_maskz_max_ps(kAll, b, a); }
  static Lanes most_of_pairs(const Lanes& a, const Lanes& b) {
    const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    const __m512i odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
    return most(_mm512_permutex2var_ps(a, even, b), _mm512_permutex2var_ps(a, odd, b));
  }
  static Lanes magnitude(const Lanes& a) { return _mm512_maskz_andnot_ps(kAll, _mm512_set1_ps(-0.0f), a); }
  static Lanes whole(const Lanes& a) {
    return _mm512_maskz_roundscale_ps(kAll, a, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
  }
  static unsigned less(const Lanes& a, const Lanes& b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
  static unsigned at_most(const Lanes& a, const Lanes& b) { return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ); }

  // Sixteen whole numbers: places of pixels, blocks and table entries.
  using Places = __m512i;
  static Places place_above(const Lanes& a) {
    return _mm512_maskz_cvt_roundps_epi32(kAll, a, _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC);
  }
  static Places place_below(const Lanes& a) {
    return _mm512_maskz_cvt_roundps_epi32(kAll, a, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
  }
  static Places spread_place(int a) { return _mm512_set1_epi32(a); }
  static Places plus(const Places& a, const Places& b) { return _mm512_add_epi32(a, b); }
  static Places minus(const Places& a, const Places& b) { return _mm512_sub_epi32(a, b); }
  static Places times(const Places& a, const Places& b) { return _mm512_mullo_epi32(a, b); }
  static Places smaller(const Places& a, const Places& b) { return _mm512_maskz_min_epi32(kAll, a, b); }
  static Places larger(const Places& a, const Places& b) { return _mm512_maskz_max_epi32(kAll, a, b); }
  static Places shifted(const Places& a, const Places& count) { return _mm512_maskz_srlv_epi32(kAll, a, count); }
  static unsigned equal(const Places& a, const Places& b) { return _mm512_cmpeq_epi32_mask(a, b); }
  static Places bit_width(const Places& a) {
    const __m512i bits = _mm512_castps_si512(_mm512_maskz_cvtepi32_ps(kAll, a));
    return larger(_mm512_sub_epi32(_mm512_maskz_srli_epi32(kAll, bits, 23), _mm512_set1_epi32(126)),
                  _mm512_setzero_si512());
  }
  static Places pick(const std::int32_t* table, const Places& at) {
    return _mm512_maskz_permutexvar_epi32(kAll, at, _mm512_loadu_si512(table));
  }
  static Lanes look_up(const float* table, const Places& at) {
    return _mm512_mask_i32gather_ps(_mm512_setzero_ps(), kAll, at, table, 4);
  }
  /// a where bits are set, else b.
  static Lanes choose(unsigned bits, const Lanes& a, const Lanes& b) {
    return _mm512_mask_blend_ps(__mmask16(bits), b, a);
  }

  static __m512i places(std::uint32_t base) {
    const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    return _mm512_add_epi32(lanes, _mm512_set1_epi32(int(base)));
  }
  static void store_places(std::uint32_t* out, std::uint32_t base) { _mm512_storeu_si512(out, places(base)); }
  /// Compresses in a register and stores it whole: compressing stores are slow on some processors.
  static std::uint32_t* append(std::uint32_t* out, std::uint32_t base, unsigned bits) {
    _mm512_storeu_si512(out, _mm512_maskz_compress_epi32(__mmask16(bits), places(base)));
    return out + _mm_popcnt_u32(bits);
  }
};

}  // namespace

}  // namespace sightline::culling
