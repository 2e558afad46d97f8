// The kernels for AVX-512 (F, BW, DQ, VL): single rays in registers of 256 bits, of which there are twice as
// many, and packets in registers of 512.
#include "sightline/raytrace/internal/kernels_avx.h"
#include "sightline/raytrace/internal/packet_impl.h"

namespace sightline::raytrace {
namespace {

constexpr __mmask16 kAll = 0xffff;  // g++ 12 warns of its own _mm512_max_ps()

struct Wide {
  __m512 v;
  static Wide load(const float* p) { return {_mm512_load_ps(p)}; }
  static Wide spread(float x) { return {_mm512_set1_ps(x)}; }
  void store(float* p) const { _mm512_store_ps(p, v); }
};
inline Wide operator+(const Wide& x, const Wide& y) {
  return {_mm512_add_ps(x.v, y.v)};
}
inline Wide operator-(const Wide& x, const Wide& y) {
  return {_mm512_sub_ps(x.v, y.v)};
}
inline Wide operator*(const Wide& x, const Wide& y) {
  return {_mm512_mul_ps(x.v, y.v)};
}
inline Wide operator/(const Wide& x, const Wide& y) {
  return {_mm512_div_ps(x.v, y.v)};
}
inline Wide most(const Wide& x, const Wide& y) {
  return {_mm512_maskz_max_ps(kAll, x.v, y.v)};
}
inline Wide least(const Wide& x, const Wide& y) {
  return {_mm512_maskz_min_ps(kAll, x.v, y.v)};
}
inline unsigned at_most(const Wide& x, const Wide& y) {
  return _mm512_cmp_ps_mask(x.v, y.v, _CMP_LE_OQ);
}
inline unsigned less(const Wide& x, const Wide& y) {
  return _mm512_cmp_ps_mask(x.v, y.v, _CMP_LT_OQ);
}
inline unsigned equal(const Wide& x, const Wide& y) {
  return _mm512_cmp_ps_mask(x.v, y.v, _CMP_EQ_OQ);
}

inline Wide magnitude(const Wide& x) {
  return {_mm512_andnot_ps(_mm512_set1_ps(-0.0f), x.v)};
}
/// Magnitudes of x with the signs of y; x must not have any.
inline Wide with_signs(const Wide& x, const Wide& y) {
  return {_mm512_or_ps(x.v, _mm512_and_ps(_mm512_set1_ps(-0.0f), y.v))};
}
/// A bit per sign.
inline unsigned signs(const Wide& x) {
  return _mm512_movepi32_mask(_mm512_castps_si512(x.v));
}

/// Folds sixteen lanes to one. By way of memory: g++ 12 warns of its own _mm512_reduce_min_ps().
template <class Fold>
float folded(__m512 x, const Fold& fold) {
  alignas(64) float lanes[kPacket];
  _mm512_store_ps(lanes, x);
  __m128 a = fold(_mm_load_ps(lanes), _mm_load_ps(lanes + 4)),
         b = fold(_mm_load_ps(lanes + 8), _mm_load_ps(lanes + 12));
  a = fold(a, b);
  a = fold(a, _mm_movehl_ps(a, a));
  return _mm_cvtss_f32(fold(a, _mm_shuffle_ps(a, a, 1)));
}
/// The lowest value of some rays, at least one.
inline float lowest_of(const Wide& x, unsigned rays) {
  const __m512 others = _mm512_set1_ps(std::numeric_limits<float>::infinity());
  return folded(_mm512_mask_mov_ps(others, __mmask16(rays), x.v), [](__m128 a, __m128 b) { return _mm_min_ps(a, b); });
}
inline float highest(const Wide& x, unsigned rays) {
  const __m512 others = _mm512_set1_ps(-std::numeric_limits<float>::infinity());
  return folded(_mm512_mask_mov_ps(others, __mmask16(rays), x.v), [](__m128 a, __m128 b) { return _mm_max_ps(a, b); });
}

struct Mask {
  __mmask8 m;
};
inline Mask operator&(Mask x, Mask y) {
  return {__mmask8(x.m & y.m)};
}
inline Mask operator|(Mask x, Mask y) {
  return {__mmask8(x.m | y.m)};
}
inline Mask operator^(Mask x, Mask y) {
  return {__mmask8(x.m ^ y.m)};
}
inline Mask operator~(Mask x) {
  return {__mmask8(~x.m)};
}
inline bool any(Mask x) {
  return x.m != 0;
}

struct Eight {
  __m512d v;
  static Eight load(const double* p) { return {_mm512_load_pd(p)}; }
  static Eight spread(double x) { return {_mm512_set1_pd(x)}; }
};
inline Eight operator+(Eight x, Eight y) {
  return {_mm512_add_pd(x.v, y.v)};
}
inline Eight operator-(Eight x, Eight y) {
  return {_mm512_sub_pd(x.v, y.v)};
}
inline Eight operator*(Eight x, Eight y) {
  return {_mm512_mul_pd(x.v, y.v)};
}
inline Eight operator/(Eight x, Eight y) {
  return {_mm512_div_pd(x.v, y.v)};
}
inline Eight operator-(Eight x) {
  return {_mm512_xor_pd(x.v, _mm512_set1_pd(-0.0))};
}
inline Mask less(Eight x, Eight y) {
  return {_mm512_cmp_pd_mask(x.v, y.v, _CMP_LT_OQ)};
}
inline Mask at_most(Eight x, Eight y) {
  return {_mm512_cmp_pd_mask(x.v, y.v, _CMP_LE_OQ)};
}
inline Mask equal(Eight x, Eight y) {
  return {_mm512_cmp_pd_mask(x.v, y.v, _CMP_EQ_OQ)};
}

struct PacketForm : Avx2 {
  using Wide = raytrace::Wide;
  using Eight = raytrace::Eight;
  using Mask = raytrace::Mask;

  static constexpr __mmask8 kEvery = 0xff;
  static Eight max(Eight a, Eight b) { return {_mm512_maskz_max_pd(kEvery, b.v, a.v)}; }
  static Eight min(Eight a, Eight b) { return {_mm512_maskz_min_pd(kEvery, b.v, a.v)}; }
  static Eight select(Mask m, Eight a, Eight b) { return {_mm512_mask_blend_pd(m.m, b.v, a.v)}; }
  static Eight root(Eight a) { return {_mm512_maskz_sqrt_pd(kEvery, a.v)}; }
  static Eight fused(Eight a, Eight b, Eight c) { return {_mm512_fmadd_pd(a.v, b.v, c.v)}; }
  static Eight magnitude(Eight a) { return {_mm512_andnot_pd(_mm512_set1_pd(-0.0), a.v)}; }
  static Eight with_sign(Eight a, Eight sign) {
    return {_mm512_or_pd(magnitude(a).v, _mm512_and_pd(_mm512_set1_pd(-0.0), sign.v))};
  }
  static Mask negative(Eight a) { return {_mm512_movepi64_mask(_mm512_castpd_si512(a.v))}; }
  static Mask every() { return {kEvery}; }
  static unsigned bits(Mask m) { return m.m; }
  static void store(double* p, unsigned which, Eight a) { _mm512_mask_store_pd(p, __mmask8(which), a.v); }
  static Eight inverse_power_of_two(Eight a) {
    const __m512i exponent = _mm512_and_si512(_mm512_castpd_si512(a.v), _mm512_set1_epi64(kExponent));
    return {_mm512_castsi512_pd(_mm512_sub_epi64(_mm512_set1_epi64(kOneOver), exponent))};
  }
  /// Rows of eight numbers become columns from `first` on.
  static void transpose(const double* rows, double* const* columns, int first) {
    __m512d pairs[8], halves[8];
    for (int i = 0; i < 8; i += 2) {
      const __m512d a = _mm512_loadu_pd(rows + 8 * i), b = _mm512_loadu_pd(rows + 8 * i + 8);
      pairs[i] = _mm512_maskz_unpacklo_pd(kEvery, a, b);
      pairs[i + 1] = _mm512_maskz_unpackhi_pd(kEvery, a, b);
    }
    for (int i = 0; i < 2; ++i)
      for (int of_four = 0; of_four < 2; ++of_four) {
        const __m512d a = pairs[4 * of_four + i], b = pairs[4 * of_four + i + 2];
        halves[4 * i + of_four] = _mm512_maskz_shuffle_f64x2(kEvery, a, b, 0x88);
        halves[4 * i + of_four + 2] = _mm512_maskz_shuffle_f64x2(kEvery, a, b, 0xdd);
      }
    for (int i = 0; i < 2; ++i)
      for (int odd = 0; odd < 2; ++odd) {
        const __m512d a = halves[4 * i + 2 * odd], b = halves[4 * i + 2 * odd + 1];
        _mm512_store_pd(columns[i + 2 * odd] + first, _mm512_maskz_shuffle_f64x2(kEvery, a, b, 0x88));
        _mm512_store_pd(columns[i + 2 * odd + 4] + first, _mm512_maskz_shuffle_f64x2(kEvery, a, b, 0xdd));
      }
  }
  /// About a third of the exponent.
  static Eight rough_cube_root(Eight a) {
    const __m512i high = _mm512_maskz_srli_epi64(kEvery, _mm512_castpd_si512(a.v), 32);
    const __m512i third =
        _mm512_maskz_srli_epi64(kEvery, _mm512_maskz_mul_epu32(kEvery, high, _mm512_set1_epi64(kThird)), 32);
    const __m512i sum = _mm512_add_epi64(third, _mm512_set1_epi64(kTwoThirds));
    return {_mm512_castsi512_pd(_mm512_maskz_slli_epi64(kEvery, sum, 32))};
  }
};

}  // namespace

const Kernels& avx512_kernels() {
  static constexpr Kernels kKernels = make_kernels<Avx2>();
  return kKernels;
}
const PacketKernels& avx512_packet_kernels() {
  static constexpr PacketKernels kKernels = make_packet_kernels<PacketForm>();
  return kKernels;
}

}  // namespace sightline::raytrace
