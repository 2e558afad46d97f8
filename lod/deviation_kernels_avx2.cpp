// The kernels for AVX2.
#include <immintrin.h>

#include "sightline/lod/internal/deviation_kernels_impl.h"

namespace sightline::lod {
namespace {

struct Four {
  __m256d d;

  static Four spread(double x) { return {_mm256_set1_pd(x)}; }
  void store(double* p) const { _mm256_storeu_pd(p, d); }
};

Four operator+(const Four& a, const Four& b) {
  return {_mm256_add_pd(a.d, b.d)};
}
Four operator-(const Four& a, const Four& b) {
  return {_mm256_sub_pd(a.d, b.d)};
}
Four operator*(const Four& a, const Four& b) {
  return {_mm256_mul_pd(a.d, b.d)};
}
Four least(const Four& a, const Four& b) {
  return {_mm256_min_pd(a.d, b.d)};
}
Four most(const Four& a, const Four& b) {
  return {_mm256_max_pd(a.d, b.d)};
}
unsigned less(const Four& a, const Four& b) {
  return unsigned(_mm256_movemask_pd(_mm256_cmp_pd(a.d, b.d, _CMP_LT_OQ)));
}

struct Avx2 {
  using Four = lod::Four;

  static Four choose(const Four& a, const Four& b, const Four& where_less, const Four& otherwise) {
    return {_mm256_blendv_pd(otherwise.d, where_less.d, _mm256_cmp_pd(a.d, b.d, _CMP_LT_OQ))};
  }
  static __m256d load(const double* low, const double* high) {
    return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_load_pd(low)), _mm_load_pd(high), 1);
  }
  static void load(const Corner* c, Four& x, Four& y, Four& z) {
    const __m256d even = load(&c[0].x, &c[2].x), odd = load(&c[1].x, &c[3].x);
    x.d = _mm256_unpacklo_pd(even, odd), y.d = _mm256_unpackhi_pd(even, odd);
    z.d = _mm256_unpacklo_pd(load(&c[0].z, &c[2].z), load(&c[1].z, &c[3].z));
  }
  static double largest(const Four& a) {
    const __m128d two = _mm_max_pd(_mm256_castpd256_pd128(a.d), _mm256_extractf128_pd(a.d, 1));
    return _mm_cvtsd_f64(_mm_max_sd(two, _mm_unpackhi_pd(two, two)));
  }
  static void copy(const Corner& from, Corner& to) {
    _mm_store_pd(&to.x, _mm_load_pd(&from.x)), _mm_store_pd(&to.z, _mm_load_pd(&from.z));
  }
  static __m128d between(__m128d a, __m128d b, double t) {
    return _mm_add_pd(a, _mm_mul_pd(_mm_set1_pd(t), _mm_sub_pd(b, a)));
  }
  static void between(const Corner& a, const Corner& b, double t, Corner& to) {
    _mm_store_pd(&to.x, between(_mm_load_pd(&a.x), _mm_load_pd(&b.x), t));
    _mm_store_pd(&to.z, between(_mm_load_pd(&a.z), _mm_load_pd(&b.z), t));
  }

  static std::uint32_t near_ones(const Balls& balls, const float* point, float most) {
    const __m256 px = _mm256_set1_ps(point[0]), py = _mm256_set1_ps(point[1]), pz = _mm256_set1_ps(point[2]);
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < kBalls; i += 8) {
      const __m256 x = _mm256_sub_ps(_mm256_loadu_ps(balls.x + i), px),
                   y = _mm256_sub_ps(_mm256_loadu_ps(balls.y + i), py),
                   z = _mm256_sub_ps(_mm256_loadu_ps(balls.z + i), pz);
      const __m256 sum = _mm256_add_ps(_mm256_loadu_ps(balls.radius + i), _mm256_set1_ps(most));
      const __m256 reach = _mm256_max_ps(sum, _mm256_setzero_ps());
      const __m256 square = _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(x, x), _mm256_mul_ps(y, y)), _mm256_mul_ps(z, z));
      const __m256 near = _mm256_cmp_ps(square, _mm256_mul_ps(reach, reach), _CMP_LT_OQ);
      bits |= std::uint32_t(_mm256_movemask_ps(near)) << i;
    }
    return bits;
  }
};

}  // namespace

const DeviationKernels& avx2_deviation_kernels() {
  static constexpr DeviationKernels kKernels = make_deviation_kernels<Avx2>();
  return kKernels;
}

}  // namespace sightline::lod
