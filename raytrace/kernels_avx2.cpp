// The kernels for AVX2.
#include "sightline/raytrace/internal/kernels_avx.h"
#include "sightline/raytrace/internal/packet_impl.h"

namespace sightline::raytrace {
namespace {

/// Two registers.
struct Wide {
  Float8 a, b;
  static Wide load(const float* p) { return {Float8::load(p), Float8::load(p + 8)}; }
  static Wide spread(float x) { return {Float8::spread(x), Float8::spread(x)}; }
  void store(float* p) const { a.store(p), b.store(p + 8); }
};
inline Wide operator+(const Wide& x, const Wide& y) {
  return {x.a + y.a, x.b + y.b};
}
inline Wide operator-(const Wide& x, const Wide& y) {
  return {x.a - y.a, x.b - y.b};
}
inline Wide operator*(const Wide& x, const Wide& y) {
  return {x.a * y.a, x.b * y.b};
}
inline Wide operator/(const Wide& x, const Wide& y) {
  return {x.a / y.a, x.b / y.b};
}
inline Wide most(const Wide& x, const Wide& y) {
  return {most(x.a, y.a), most(x.b, y.b)};
}
inline Wide least(const Wide& x, const Wide& y) {
  return {least(x.a, y.a), least(x.b, y.b)};
}
inline unsigned at_most(const Wide& x, const Wide& y) {
  return at_most(x.a, y.a) | at_most(x.b, y.b) << 8;
}
inline unsigned less(const Wide& x, const Wide& y) {
  return less(x.a, y.a) | less(x.b, y.b) << 8;
}
inline unsigned equal(const Wide& x, const Wide& y) {
  return equal(x.a, y.a) | equal(x.b, y.b) << 8;
}
inline Wide magnitude(const Wide& x) {
  return {magnitude(x.a), magnitude(x.b)};
}
/// Magnitudes of x with the signs of y; x must not have any.
inline Wide with_signs(const Wide& x, const Wide& y) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  return {{_mm256_or_ps(x.a.v, _mm256_and_ps(sign, y.a.v))}, {_mm256_or_ps(x.b.v, _mm256_and_ps(sign, y.b.v))}};
}
/// A bit per sign.
inline unsigned signs(const Wide& x) {
  return unsigned(_mm256_movemask_ps(x.a.v)) | unsigned(_mm256_movemask_ps(x.b.v)) << 8;
}

/// The first value of some rays in an order, at least one. `start`: after all.
template <class Before>
float first_of(const Wide& x, unsigned rays, float start, const Before& before) {
  float lanes[kPacket];
  x.store(lanes);
  for (; rays != 0; rays &= rays - 1) {
    const float lane = lanes[core::lowest_bit(rays)];
    start = before(lane, start) ? lane : start;
  }
  return start;
}
inline float lowest_of(const Wide& x, unsigned rays) {
  return first_of(x, rays, std::numeric_limits<float>::infinity(), [](float a, float b) { return a < b; });
}
inline float highest(const Wide& x, unsigned rays) {
  return first_of(x, rays, -std::numeric_limits<float>::infinity(), [](float a, float b) { return a > b; });
}

struct Mask {
  __m256d a, b;
};
inline Mask operator&(const Mask& x, const Mask& y) {
  return {_mm256_and_pd(x.a, y.a), _mm256_and_pd(x.b, y.b)};
}
inline Mask operator|(const Mask& x, const Mask& y) {
  return {_mm256_or_pd(x.a, y.a), _mm256_or_pd(x.b, y.b)};
}
inline Mask operator^(const Mask& x, const Mask& y) {
  return {_mm256_xor_pd(x.a, y.a), _mm256_xor_pd(x.b, y.b)};
}
inline Mask every_lane() {
  const __m256d ones = _mm256_castsi256_pd(_mm256_set1_epi64x(-1));
  return {ones, ones};
}
inline Mask operator~(const Mask& x) {
  return x ^ every_lane();
}
inline bool any(const Mask& x) {
  return _mm256_movemask_pd(_mm256_or_pd(x.a, x.b)) != 0;
}

/// Two registers.
struct Eight {
  __m256d a, b;
  static Eight load(const double* p) { return {_mm256_load_pd(p), _mm256_load_pd(p + 4)}; }
  static Eight spread(double x) { return {_mm256_set1_pd(x), _mm256_set1_pd(x)}; }
};
inline Eight operator+(const Eight& x, const Eight& y) {
  return {_mm256_add_pd(x.a, y.a), _mm256_add_pd(x.b, y.b)};
}
inline Eight operator-(const Eight& x, const Eight& y) {
  return {_mm256_sub_pd(x.a, y.a), _mm256_sub_pd(x.b, y.b)};
}
inline Eight operator*(const Eight& x, const Eight& y) {
  return {_mm256_mul_pd(x.a, y.a), _mm256_mul_pd(x.b, y.b)};
}
inline Eight operator/(const Eight& x, const Eight& y) {
  return {_mm256_div_pd(x.a, y.a), _mm256_div_pd(x.b, y.b)};
}
inline Eight operator-(const Eight& x) {
  const __m256d sign = _mm256_set1_pd(-0.0);
  return {_mm256_xor_pd(x.a, sign), _mm256_xor_pd(x.b, sign)};
}
template <int kRelation>
Mask compared(const Eight& x, const Eight& y) {
  return {_mm256_cmp_pd(x.a, y.a, kRelation), _mm256_cmp_pd(x.b, y.b, kRelation)};
}
inline Mask less(const Eight& x, const Eight& y) {
  return compared<_CMP_LT_OQ>(x, y);
}
inline Mask at_most(const Eight& x, const Eight& y) {
  return compared<_CMP_LE_OQ>(x, y);
}
inline Mask equal(const Eight& x, const Eight& y) {
  return compared<_CMP_EQ_OQ>(x, y);
}

struct PacketForm : Avx2 {
  using Wide = raytrace::Wide;
  using Eight = raytrace::Eight;
  using Mask = raytrace::Mask;

  static Eight max(const Eight& x, const Eight& y) { return {_mm256_max_pd(y.a, x.a), _mm256_max_pd(y.b, x.b)}; }
  static Eight min(const Eight& x, const Eight& y) { return {_mm256_min_pd(y.a, x.a), _mm256_min_pd(y.b, x.b)}; }
  static Eight select(const Mask& m, const Eight& x, const Eight& y) {
    return {_mm256_blendv_pd(y.a, x.a, m.a), _mm256_blendv_pd(y.b, x.b, m.b)};
  }
  static Eight root(const Eight& x) { return {_mm256_sqrt_pd(x.a), _mm256_sqrt_pd(x.b)}; }
  static Eight fused(const Eight& x, const Eight& y, const Eight& z) {
    return {_mm256_fmadd_pd(x.a, y.a, z.a), _mm256_fmadd_pd(x.b, y.b, z.b)};
  }
  static Eight magnitude(const Eight& x) {
    const __m256d sign = _mm256_set1_pd(-0.0);
    return {_mm256_andnot_pd(sign, x.a), _mm256_andnot_pd(sign, x.b)};
  }
  static Eight with_sign(const Eight& x, const Eight& sign) {
    const __m256d s = _mm256_set1_pd(-0.0);
    return {_mm256_or_pd(_mm256_andnot_pd(s, x.a), _mm256_and_pd(s, sign.a)),
            _mm256_or_pd(_mm256_andnot_pd(s, x.b), _mm256_and_pd(s, sign.b))};
  }
  /// By their signs, as select() reads masks; ~ and the like keep them right.
  static Mask negative(const Eight& x) { return {x.a, x.b}; }
  static Mask every() { return every_lane(); }
  static unsigned bits(const Mask& m) {
    return unsigned(_mm256_movemask_pd(m.a)) | unsigned(_mm256_movemask_pd(m.b)) << 4;
  }
  static void store(double* p, unsigned which, const Eight& x) {
    const __m256i lanes = _mm256_setr_epi64x(1, 2, 4, 8), all = _mm256_set1_epi64x(which);
    const __m256i low = _mm256_cmpeq_epi64(_mm256_and_si256(all, lanes), lanes);
    const __m256i high_lanes = _mm256_slli_epi64(lanes, 4);
    const __m256i high = _mm256_cmpeq_epi64(_mm256_and_si256(all, high_lanes), high_lanes);
    _mm256_maskstore_pd(p, low, x.a);
    _mm256_maskstore_pd(p + 4, high, x.b);
  }
  static __m256d inverse_power_of_two(__m256d x) {
    const __m256i exponent = _mm256_and_si256(_mm256_castpd_si256(x), _mm256_set1_epi64x(kExponent));
    return _mm256_castsi256_pd(_mm256_sub_epi64(_mm256_set1_epi64x(kOneOver), exponent));
  }
  static Eight inverse_power_of_two(const Eight& x) { return {inverse_power_of_two(x.a), inverse_power_of_two(x.b)}; }
  /// Rows of eight numbers become columns from `first` on.
  static void transpose(const double* rows, double* const* columns, int first) {
    for (int row = 0; row < 8; row += 4)
      for (int column = 0; column < 8; column += 4) {
        const double* const block = rows + 8 * row + column;
        const __m256d a = _mm256_loadu_pd(block), b = _mm256_loadu_pd(block + 8);
        const __m256d c = _mm256_loadu_pd(block + 16), d = _mm256_loadu_pd(block + 24);
        const __m256d ab_even = _mm256_unpacklo_pd(a, b), ab_odd = _mm256_unpackhi_pd(a, b);
        const __m256d cd_even = _mm256_unpacklo_pd(c, d), cd_odd = _mm256_unpackhi_pd(c, d);
        _mm256_store_pd(columns[column] + first + row, _mm256_permute2f128_pd(ab_even, cd_even, 0x20));
        _mm256_store_pd(columns[column + 1] + first + row, _mm256_permute2f128_pd(ab_odd, cd_odd, 0x20));
        _mm256_store_pd(columns[column + 2] + first + row, _mm256_permute2f128_pd(ab_even, cd_even, 0x31));
        _mm256_store_pd(columns[column + 3] + first + row, _mm256_permute2f128_pd(ab_odd, cd_odd, 0x31));
      }
  }
  /// About a third of the exponent.
  static __m256d rough_cube_root(__m256d x) {
    const __m256i high = _mm256_srli_epi64(_mm256_castpd_si256(x), 32);
    const __m256i third = _mm256_srli_epi64(_mm256_mul_epu32(high, _mm256_set1_epi64x(kThird)), 32);
    return _mm256_castsi256_pd(_mm256_slli_epi64(_mm256_add_epi64(third, _mm256_set1_epi64x(kTwoThirds)), 32));
  }
  static Eight rough_cube_root(const Eight& x) { return {rough_cube_root(x.a), rough_cube_root(x.b)}; }
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
