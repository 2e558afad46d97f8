#include "sightline/apps/bench/brute_force.h"

#if defined(__GNUC__) && defined(__x86_64__)
#include <immintrin.h>
#define SIGHTLINE_BENCH_AVX2 1
#endif

namespace sightline::bench {
namespace {

struct Planes {
  float normal[6][3], offset[6];
  const float* corner[6][3];  // arrays of the p-vertex
};

/// Both read up to 15 boxes beyond `count`; ItemBounds has padding for them.
void plain(const Planes& planes, std::size_t count, std::uint8_t* bits) {
  for (std::size_t i = 0; i < count; i += 8) {
    unsigned group = 0;
    for (unsigned lane = 0; lane < 8; ++lane) {
      bool inside = true;
      for (int k = 0; k < 6 && inside; ++k) {
        const float* n = planes.normal[k];
        const auto& c = planes.corner[k];
        inside = n[0] * c[0][i + lane] + n[1] * c[1][i + lane] + n[2] * c[2][i + lane] + planes.offset[k] >= 0.0f;
      }
      group |= unsigned(inside) << lane;
    }
    bits[i / 8] = std::uint8_t(group);
  }
}

#ifdef SIGHTLINE_BENCH_AVX2
__attribute__((target("avx2,fma"))) void wide(const Planes& planes, std::size_t count, std::uint8_t* bits) {
  for (std::size_t i = 0; i < count; i += 8) {
    int outside = 0;
    for (int k = 0; k < 6 && outside != 0xff; ++k) {
      const auto& c = planes.corner[k];
      const float* n = planes.normal[k];
      __m256 s = _mm256_fmadd_ps(_mm256_set1_ps(n[0]), _mm256_loadu_ps(c[0] + i), _mm256_set1_ps(planes.offset[k]));
      s = _mm256_fmadd_ps(_mm256_set1_ps(n[1]), _mm256_loadu_ps(c[1] + i), s);
      s = _mm256_fmadd_ps(_mm256_set1_ps(n[2]), _mm256_loadu_ps(c[2] + i), s);
      outside |= _mm256_movemask_ps(s);  // sign bits
    }
    bits[i / 8] = std::uint8_t(~outside);
  }
}
bool have_wide() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
}
#else
constexpr auto wide = plain;
bool have_wide() {
  return false;
}
#endif

}  // namespace

BruteForce::BruteForce(std::span<const core::Aabb> boxes) : bits_((boxes.size() + 7) / 8) {
  bounds_.resize(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) bounds_.set(i, boxes[i]);
}

void BruteForce::cull(const core::View& view) {
  Planes planes;
  const auto exact = core::frustum_planes(view.clip_from_world(), view.clip_depth());
  for (int k = 0; k < 6; ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      planes.normal[k][axis] = float(exact[std::size_t(k)].normal[axis]);
      planes.corner[k][axis] = bounds_.coordinate(planes.normal[k][axis] >= 0.0f ? axis + 3 : axis);
    }
    planes.offset[k] = float(exact[std::size_t(k)].offset);
  }
  (have_wide() ? wide : plain)(planes, bounds_.size(), bits_.data());
}

std::uint64_t BruteForce::count() const {
  std::uint64_t n = 0;
  for (std::size_t i = 0; i < bounds_.size(); ++i) n += bits_[i / 8] >> i % 8 & 1u;
  return n;
}

std::vector<std::uint32_t> BruteForce::ids() const {
  std::vector<std::uint32_t> out;
  for (std::uint32_t i = 0; i < bounds_.size(); ++i)
    if ((bits_[i / 8] >> i % 8 & 1u) != 0) out.push_back(i);
  return out;
}

const char* BruteForce::name() {
  return have_wide() ? "brute force AVX2" : "brute force plain";
}

}  // namespace sightline::bench
