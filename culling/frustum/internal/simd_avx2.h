// Internal: sixteen lanes with AVX2, in two registers. For files that are compiled for it; lies in the anonymous
// namespace of each, so that every instance of a kernel is local to its file.
#pragma once

#include <cstdint>

#include <immintrin.h>

#include "sightline/culling/frustum/frustum_test.h"
#include "sightline/culling/frustum/internal/compress_table.h"
#include "sightline/culling/frustum/internal/simd_avx.h"

namespace sightline::culling {
namespace {

struct Avx2 {
  struct Plane {
    __m256 x, y, z, d, band, minus_band;
  };
  // Sixteen floats, for screen_boxes.h.
  struct Lanes {
    __m256 low, high;
  };
  using Values = Lanes;

  static Plane spread(const FloatPlane& p) {
    return {_mm256_set1_ps(p.normal[0]), _mm256_set1_ps(p.normal[1]), _mm256_set1_ps(p.normal[2]),
            _mm256_set1_ps(p.offset),    _mm256_set1_ps(p.band),      _mm256_set1_ps(-p.band)};
  }
  static __m256 evaluate_half(const Plane& p, const float* x, const float* y, const float* z) {
    const __m256 xy = _mm256_add_ps(_mm256_mul_ps(p.x, _mm256_loadu_ps(x)), _mm256_mul_ps(p.y, _mm256_loadu_ps(y)));
    return _mm256_add_ps(_mm256_add_ps(xy, _mm256_mul_ps(p.z, _mm256_loadu_ps(z))), p.d);
  }
  static Values evaluate(const Plane& p, const float* x, const float* y, const float* z) {
    return {evaluate_half(p, x, y, z), evaluate_half(p, x + 8, y + 8, z + 8)};
  }
  static unsigned join(__m256 low, __m256 high) {
    return unsigned(_mm256_movemask_ps(low)) | unsigned(_mm256_movemask_ps(high)) << 8;
  }
  static unsigned below(const Values& s, const Plane& p) {
    return join(_mm256_cmp_ps(s.low, p.minus_band, _CMP_LT_OQ), _mm256_cmp_ps(s.high, p.minus_band, _CMP_LT_OQ));
  }
  static unsigned above(const Values& s, const Plane& p) {
    return join(_mm256_cmp_ps(s.low, p.band, _CMP_GE_OQ), _mm256_cmp_ps(s.high, p.band, _CMP_GE_OQ));
  }
  static Lanes load(const float* a) { return {_mm256_loadu_ps(a), _mm256_loadu_ps(a + 8)}; }
  static void store(float* out, const Lanes& a) {
    _mm256_storeu_ps(out, a.low);
    _mm256_storeu_ps(out + 8, a.high);
  }
  static void raise_half(float* at, __m256 a, unsigned bits) {
    const __m256i places = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    const __m256i chosen = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(int(bits)), places), places);
    _mm256_maskstore_ps(at, chosen, _mm256_max_ps(a, _mm256_loadu_ps(at)));
  }
  static void raise(float* at, const Lanes& a, unsigned bits) {
    raise_half(at, a.low, bits & 0xffu);
    raise_half(at + 8, a.high, bits >> 8);
  }
  static Lanes spread(float a) { return {_mm256_set1_ps(a), _mm256_set1_ps(a)}; }
  static Lanes ramp() { return {_mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7), _mm256_setr_ps(8, 9, 10, 11, 12, 13, 14, 15)}; }
  static Lanes add(const Lanes& a, const Lanes& b) {
    return {_mm256_add_ps(a.low, b.low), _mm256_add_ps(a.high, b.high)};
  }
  static Lanes subtract(const Lanes& a, const Lanes& b) {
    return {_mm256_sub_ps(a.low, b.low), _mm256_sub_ps(a.high, b.high)};
  }
  static Lanes multiply(const Lanes& a, const Lanes& b) {
    return {_mm256_mul_ps(a.low, b.low), _mm256_mul_ps(a.high, b.high)};
  }
  static Lanes divide(const Lanes& a, const Lanes& b) {
    return {_mm256_div_ps(a.low, b.low), _mm256_div_ps(a.high, b.high)};
  }
  static Lanes root(const Lanes& a) { return {_mm256_sqrt_ps(a.low), _mm256_sqrt_ps(a.high)}; }
  static Lanes least(const Lanes& a, const Lanes& b) {
    return {_mm256_min_ps(a.low, b.low), _mm256_min_ps(a.high, b.high)};
  }
  static Lanes most(const Lanes& a, const Lanes& b) {
    return {_mm256_max_ps(b.low, a.low), _mm256_max_ps(b.high, a.high)};
  }
  static __m256 most_of_pairs_half(__m256 a, __m256 b) {
    const __m256 most = _mm256_max_ps(_mm256_shuffle_ps(a, b, 0x88), _mm256_shuffle_ps(a, b, 0xdd));
    return _mm256_castpd_ps(_mm256_permute4x64_pd(_mm256_castps_pd(most), 0xd8));
  }
  static Lanes most_of_pairs(const Lanes& a, const Lanes& b) {
    return {most_of_pairs_half(a.low, a.high), most_of_pairs_half(b.low, b.high)};
  }
  static Lanes magnitude(const Lanes& a) {
    const __m256 sign = _mm256_set1_ps(-0.0f);
    return {_mm256_andnot_ps(sign, a.low), _mm256_andnot_ps(sign, a.high)};
  }
  static Lanes whole(const Lanes& a) { return {_mm256_floor_ps(a.low), _mm256_floor_ps(a.high)}; }
  static unsigned less(const Lanes& a, const Lanes& b) {
    return join(_mm256_cmp_ps(a.low, b.low, _CMP_LT_OQ), _mm256_cmp_ps(a.high, b.high, _CMP_LT_OQ));
  }
  static unsigned at_most(const Lanes& a, const Lanes& b) {
    return join(_mm256_cmp_ps(a.low, b.low, _CMP_LE_OQ), _mm256_cmp_ps(a.high, b.high, _CMP_LE_OQ));
  }
  // Sixteen whole numbers: places of pixels, blocks and table entries.
  struct Places {
    __m256i low, high;
  };
  static Places place_above(const Lanes& a) {
    return {_mm256_cvtps_epi32(_mm256_ceil_ps(a.low)), _mm256_cvtps_epi32(_mm256_ceil_ps(a.high))};
  }
  static Places place_below(const Lanes& a) {
    return {_mm256_cvtps_epi32(_mm256_floor_ps(a.low)), _mm256_cvtps_epi32(_mm256_floor_ps(a.high))};
  }
  static Places spread_place(int a) { return {_mm256_set1_epi32(a), _mm256_set1_epi32(a)}; }
  static Places plus(const Places& a, const Places& b) {
    return {_mm256_add_epi32(a.low, b.low), _mm256_add_epi32(a.high, b.high)};
  }
  static Places minus(const Places& a, const Places& b) {
    return {_mm256_sub_epi32(a.low, b.low), _mm256_sub_epi32(a.high, b.high)};
  }
  static Places times(const Places& a, const Places& b) {
    return {_mm256_mullo_epi32(a.low, b.low), _mm256_mullo_epi32(a.high, b.high)};
  }
  static Places smaller(const Places& a, const Places& b) {
    return {_mm256_min_epi32(a.low, b.low), _mm256_min_epi32(a.high, b.high)};
  }
  static Places larger(const Places& a, const Places& b) {
    return {_mm256_max_epi32(a.low, b.low), _mm256_max_epi32(a.high, b.high)};
  }
  static Places shifted(const Places& a, const Places& count) {
    return {_mm256_srlv_epi32(a.low, count.low), _mm256_srlv_epi32(a.high, count.high)};
  }
  static unsigned equal(const Places& a, const Places& b) {
    return join(_mm256_castsi256_ps(_mm256_cmpeq_epi32(a.low, b.low)),
                _mm256_castsi256_ps(_mm256_cmpeq_epi32(a.high, b.high)));
  }
  static __m256i bit_width_half(__m256i a) {
    const __m256i bits = _mm256_castps_si256(_mm256_cvtepi32_ps(a));
    return _mm256_max_epi32(_mm256_sub_epi32(_mm256_srli_epi32(bits, 23), _mm256_set1_epi32(126)),
                            _mm256_setzero_si256());
  }
  static Places bit_width(const Places& a) { return {bit_width_half(a.low), bit_width_half(a.high)}; }
  static __m256i pick_half(const std::int32_t* table, __m256i at) {
    const auto eight = [&](int first) {
      return _mm256_permutevar8x32_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(table + first)), at);
    };
    return _mm256_blendv_epi8(eight(0), eight(8), _mm256_cmpgt_epi32(at, _mm256_set1_epi32(7)));
  }
  static Places pick(const std::int32_t* table, const Places& at) {
    return {pick_half(table, at.low), pick_half(table, at.high)};
  }
  static Lanes look_up(const float* table, const Places& at) {
    return {_mm256_i32gather_ps(table, at.low, 4), _mm256_i32gather_ps(table, at.high, 4)};
  }
  static __m256 choose_half(unsigned bits, __m256 a, __m256 b) {
    const __m256i own = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    const __m256i set = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(int(bits)), own), own);
    return _mm256_blendv_ps(b, a, _mm256_castsi256_ps(set));
  }
  /// a where bits are set, else b.
  static Lanes choose(unsigned bits, const Lanes& a, const Lanes& b) {
    return {choose_half(bits, a.low, b.low), choose_half(bits >> 8, a.high, b.high)};
  }

  static float least(const float* a) { return least_of_leaf(a); }
  static float most(const float* a) { return most_of_leaf(a); }
  static unsigned share_half(const std::uint32_t* layers, std::uint32_t mask) {
    const __m256i own = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(layers));
    const __m256i common = _mm256_and_si256(own, _mm256_set1_epi32(int(mask)));
    const __m256i none = _mm256_cmpeq_epi32(common, _mm256_setzero_si256());
    return ~unsigned(_mm256_movemask_ps(_mm256_castsi256_ps(none))) & 0xffu;
  }
  static unsigned share(const std::uint32_t* layers, std::uint32_t mask) {
    return share_half(layers, mask) | share_half(layers + 8, mask) << 8;
  }
  static std::uint32_t* append_half(std::uint32_t* out, std::uint32_t base, unsigned bits) {
    const __m128i places = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(kCompress.rows[bits]));
    const __m256i values = _mm256_add_epi32(_mm256_cvtepu8_epi32(places), _mm256_set1_epi32(int(base)));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), values);
    return out + _mm_popcnt_u32(bits);
  }
  static void store_places(std::uint32_t* out, std::uint32_t base) {
    append_half(out, base, 0xff);
    append_half(out + 8, base + 8, 0xff);
  }
  static std::uint32_t* append(std::uint32_t* out, std::uint32_t base, unsigned bits) {
    return append_half(append_half(out, base, bits & 0xffu), base + 8, bits >> 8);
  }
};

}  // namespace

}  // namespace sightline::culling
