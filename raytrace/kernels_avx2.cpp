// The kernels for AVX2.
#include "sightline/raytrace/internal/kernels_avx.h"
#include "sightline/raytrace/internal/packet_impl.h"

namespace sightline::raytrace {
namespace {

/// Two registers.
struct Wide {
  __m256 a, b;
  static Wide load(const float* p) { return {_mm256_load_ps(p), _mm256_load_ps(p + 8)}; }
  static Wide spread(float x) { return {_mm256_set1_ps(x), _mm256_set1_ps(x)}; }
  void store(float* p) const { _mm256_store_ps(p, a), _mm256_store_ps(p + 8, b); }
};
inline Wide operator+(const Wide& x, const Wide& y) {
  return {_mm256_add_ps(x.a, y.a), _mm256_add_ps(x.b, y.b)};
}
inline Wide operator-(const Wide& x, const Wide& y) {
  return {_mm256_sub_ps(x.a, y.a), _mm256_sub_ps(x.b, y.b)};
}
inline Wide operator*(const Wide& x, const Wide& y) {
  return {_mm256_mul_ps(x.a, y.a), _mm256_mul_ps(x.b, y.b)};
}
inline Wide operator/(const Wide& x, const Wide& y) {
  return {_mm256_div_ps(x.a, y.a), _mm256_div_ps(x.b, y.b)};
}
inline Wide most(const Wide& x, const Wide& y) {
  return {_mm256_max_ps(x.a, y.a), _mm256_max_ps(x.b, y.b)};
}
inline Wide least(const Wide& x, const Wide& y) {
  return {_mm256_min_ps(x.a, y.a), _mm256_min_ps(x.b, y.b)};
}
template <int kRelation>
unsigned compare(const Wide& x, const Wide& y) {
  return unsigned(_mm256_movemask_ps(_mm256_cmp_ps(x.a, y.a, kRelation))) |
         unsigned(_mm256_movemask_ps(_mm256_cmp_ps(x.b, y.b, kRelation))) << 8;
}
inline unsigned at_most(const Wide& x, const Wide& y) {
  return compare<_CMP_LE_OQ>(x, y);
}
inline unsigned less(const Wide& x, const Wide& y) {
  return compare<_CMP_LT_OQ>(x, y);
}
inline unsigned equal(const Wide& x, const Wide& y) {
  return compare<_CMP_EQ_OQ>(x, y);
}

inline Wide magnitude(const Wide& x) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  return {_mm256_andnot_ps(sign, x.a), _mm256_andnot_ps(sign, x.b)};
}
/// Magnitudes of x with the signs of y; x must not have any.
inline Wide with_signs(const Wide& x, const Wide& y) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  return {_mm256_or_ps(x.a, _mm256_and_ps(sign, y.a)), _mm256_or_ps(x.b, _mm256_and_ps(sign, y.b))};
}
/// A bit per sign.
inline unsigned signs(const Wide& x) {
  return unsigned(_mm256_movemask_ps(x.a)) | unsigned(_mm256_movemask_ps(x.b)) << 8;
}

/// Of some rays, at least one.
inline float lowest_of(const Wide& x, unsigned rays) {
  alignas(32) float lanes[kPacket];
  x.store(lanes);
  float result = std::numeric_limits<float>::infinity();
  for (; rays != 0; rays &= rays - 1) {
    const float lane = lanes[core::lowest_bit(rays)];
    result = lane < result ? lane : result;
  }
  return result;
}
inline float highest(const Wide& x, unsigned rays) {
  alignas(32) float lanes[kPacket];
  x.store(lanes);
  float result = -std::numeric_limits<float>::infinity();
  for (; rays != 0; rays &= rays - 1) {
    const float lane = lanes[core::lowest_bit(rays)];
    result = lane > result ? lane : result;
  }
  return result;
}

struct PacketForm : Avx2 {
  using Wide = raytrace::Wide;
};

}  // namespace

const Kernels& avx2_kernels() {
  static constexpr Kernels kKernels = make_kernels<Avx2>();
  return kKernels;
}
const PacketKernels& avx2_packet_kernels() {
  static constexpr PacketKernels kKernels = make_packet_kernels<PacketForm>();
  return kKernels;
}

}  // namespace sightline::raytrace
