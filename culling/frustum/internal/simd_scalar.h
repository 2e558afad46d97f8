// Internal: sixteen lanes in plain C++, the reference for the other forms. Lies in the anonymous namespace of each file
// that includes it, so that every instance of a kernel is local to its file.
#pragma once

#include <cmath>
#include <cstdint>

#include "sightline/core/internal/intrinsics.h"
#include "sightline/culling/frustum/frustum_test.h"
#include "sightline/culling/frustum/hierarchy.h"

namespace sightline::culling {
namespace {

struct Scalar {
  struct Plane {
    float x, y, z, d, band, minus_band;
  };
  // Sixteen floats, for screen_boxes.h.
  struct Lanes {
    float v[kLanes];
  };
  using Values = Lanes;
  template <class Result = Lanes, class Of>
  static Result each(const Of& of) {
    Result r;
    for (int i = 0; i < kLanes; ++i) r.v[i] = of(i);
    return r;
  }
  template <class Of>
  static unsigned bits(const Of& of) {
    unsigned r = 0;
    for (int i = 0; i < kLanes; ++i) r |= unsigned(of(i)) << i;
    return r;
  }

  static Plane spread(const FloatPlane& p) {
    return {p.normal[0], p.normal[1], p.normal[2], p.offset, p.band, -p.band};
  }
  static Values evaluate(const Plane& p, const float* x, const float* y, const float* z) {
    return each([&](int i) { return ((p.x * x[i] + p.y * y[i]) + p.z * z[i]) + p.d; });
  }
  static unsigned below(const Values& s, const Plane& p) {
    return bits([&](int i) { return s.v[i] < p.minus_band; });
  }
  static unsigned above(const Values& s, const Plane& p) {
    return bits([&](int i) { return s.v[i] >= p.band; });
  }
  /// Minimum of a whole leaf, none of it NaN.
  static float least(const float* a) {
    float r = a[0];
    for (std::uint32_t i = 1; i < kLeafSize; ++i) r = a[i] < r ? a[i] : r;
    return r;
  }
  static float most(const float* a) {
    float r = a[0];
    for (std::uint32_t i = 1; i < kLeafSize; ++i) r = a[i] > r ? a[i] : r;
    return r;
  }
  static Lanes load(const float* a) {
    return each([&](int i) { return a[i]; });
  }
  static void store(float* out, const Lanes& a) {
    for (int i = 0; i < kLanes; ++i) out[i] = a.v[i];
  }
  /// at[i] = the greater of at[i] and a[i], for the lanes of `bits`.
  static void raise(float* at, const Lanes& a, unsigned bits) {
    for (int i = 0; i < kLanes; ++i)
      if ((bits >> i & 1u) != 0 && at[i] < a.v[i]) at[i] = a.v[i];
  }
  static Lanes spread(float a) {
    return each([&](int) { return a; });
  }
  /// 0, 1, 2 …
  static Lanes ramp() {
    return each([&](int i) { return float(i); });
  }
  static Lanes add(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return a.v[i] + b.v[i]; });
  }
  static Lanes subtract(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return a.v[i] - b.v[i]; });
  }
  static Lanes multiply(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return a.v[i] * b.v[i]; });
  }
  static Lanes divide(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return a.v[i] / b.v[i]; });
  }
  static Lanes root(const Lanes& a) {
    return each([&](int i) { return std::sqrt(a.v[i]); });
  }
  static Lanes least(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return a.v[i] < b.v[i] ? a.v[i] : b.v[i]; });
  }
  static Lanes most(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return a.v[i] < b.v[i] ? b.v[i] : a.v[i]; });
  }
  /// The greater of lanes 2 i and 2 i + 1, first of a, then of b.
  static Lanes most_of_pairs(const Lanes& a, const Lanes& b) {
    return each([&](int i) {
      const float* pair = i < kLanes / 2 ? a.v + 2 * i : b.v + 2 * i - kLanes;
      return pair[0] < pair[1] ? pair[1] : pair[0];
    });
  }
  static Lanes magnitude(const Lanes& a) {
    return each([&](int i) { return a.v[i] < 0.0f ? -a.v[i] : a.v[i]; });
  }
  /// The next whole number below; for a >= 0. Where a lies between -1 and 0, some whole number.
  static Lanes whole(const Lanes& a) {
    return each([&](int i) { return float(int(a.v[i])); });
  }
  static unsigned less(const Lanes& a, const Lanes& b) {
    return bits([&](int i) { return a.v[i] < b.v[i]; });
  }
  static unsigned at_most(const Lanes& a, const Lanes& b) {
    return bits([&](int i) { return a.v[i] <= b.v[i]; });
  }
  // Sixteen whole numbers: places of pixels, blocks and table entries.
  struct Places {
    std::int32_t v[kLanes];
  };
  /// Places whose a is at least 0.
  static Places place_above(const Lanes& a) {
    return each<Places>([&](int i) { return int(a.v[i]) + int(float(int(a.v[i])) < a.v[i]); });
  }
  static Places place_below(const Lanes& a) {
    return each<Places>([&](int i) { return int(a.v[i]); });
  }
  static Places spread_place(int a) {
    return each<Places>([&](int) { return a; });
  }
  static Places plus(const Places& a, const Places& b) {
    return each<Places>([&](int i) { return a.v[i] + b.v[i]; });
  }
  static Places minus(const Places& a, const Places& b) {
    return each<Places>([&](int i) { return a.v[i] - b.v[i]; });
  }
  static Places times(const Places& a, const Places& b) {
    return each<Places>([&](int i) { return a.v[i] * b.v[i]; });
  }
  static Places smaller(const Places& a, const Places& b) {
    return each<Places>([&](int i) { return a.v[i] < b.v[i] ? a.v[i] : b.v[i]; });
  }
  static Places larger(const Places& a, const Places& b) {
    return each<Places>([&](int i) { return a.v[i] < b.v[i] ? b.v[i] : a.v[i]; });
  }
  static Places shifted(const Places& a, const Places& count) {
    return each<Places>([&](int i) { return a.v[i] >> count.v[i]; });
  }
  static unsigned equal(const Places& a, const Places& b) {
    return bits([&](int i) { return a.v[i] == b.v[i]; });
  }
  /// Bits that a number takes, 0 for one that is not positive; anything for one below 0 in the other forms.
  static Places bit_width(const Places& a) {
    return each<Places>([&](int i) {
      int width = 0;
      for (std::int32_t rest = a.v[i]; rest > 0; rest >>= 1) ++width;
      return width;
    });
  }
  /// Entries of sixteen.
  static Places pick(const std::int32_t* table, const Places& at) {
    return each<Places>([&](int i) { return table[at.v[i]]; });
  }
  static Lanes look_up(const float* table, const Places& at) {
    return each([&](int i) { return table[at.v[i]]; });
  }
  /// a where bits are set, else b.
  static Lanes choose(unsigned bits, const Lanes& a, const Lanes& b) {
    return each([&](int i) { return (bits >> i & 1u) != 0 ? a.v[i] : b.v[i]; });
  }

  static unsigned share(const std::uint32_t* layers, std::uint32_t mask) {
    return bits([&](int i) { return (layers[i] & mask) != 0; });
  }
  static void store_places(std::uint32_t* out, std::uint32_t base) {
    for (unsigned i = 0; i < unsigned(kLanes); ++i) out[i] = base + i;
  }
  static std::uint32_t* append(std::uint32_t* out, std::uint32_t base, unsigned bits) {
    for (; bits != 0; bits &= bits - 1) *out++ = base + core::lowest_bit(bits);
    return out;
  }
};

}  // namespace

}  // namespace sightline::culling
