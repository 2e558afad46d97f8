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
/// Of some rays, at least one.
inline float lowest_of(const Wide& x, unsigned rays) {
  const __m512 others = _mm512_set1_ps(std::numeric_limits<float>::infinity());
  return folded(_mm512_mask_mov_ps(others, __mmask16(rays), x.v), [](__m128 a, __m128 b) { return _mm_min_ps(a, b); });
}
inline float highest(const Wide& x, unsigned rays) {
  const __m512 others = _mm512_set1_ps(-std::numeric_limits<float>::infinity());
  return folded(_mm512_mask_mov_ps(others, __mmask16(rays), x.v), [](__m128 a, __m128 b) { return _mm_max_ps(a, b); });
}

struct PacketForm : Avx2 {
  using Wide = raytrace::Wide;
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
