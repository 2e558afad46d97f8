// The plain form of the kernels: the reference for the others, and the form for other processors.
#include "sightline/culling/internal/kernels_impl.h"

namespace sightline::culling {
namespace {

struct Scalar {
  struct Plane {
    float x, y, z, d, band, minus_band;
  };
  struct Values {
    float v[kLanes];
  };

  static Plane spread(const FloatPlane& p) {
    return {p.normal[0], p.normal[1], p.normal[2], p.offset, p.band, -p.band};
  }
  static Values evaluate(const Plane& p, const float* x, const float* y, const float* z) {
    Values s;
    for (int i = 0; i < kLanes; ++i) s.v[i] = ((p.x * x[i] + p.y * y[i]) + p.z * z[i]) + p.d;
    return s;
  }
  static unsigned below(const Values& s, const Plane& p) {
    unsigned bits = 0;
    for (int i = 0; i < kLanes; ++i) bits |= unsigned(s.v[i] < p.minus_band) << i;
    return bits;
  }
  static unsigned above(const Values& s, const Plane& p) {
    unsigned bits = 0;
    for (int i = 0; i < kLanes; ++i) bits |= unsigned(s.v[i] >= p.band) << i;
    return bits;
  }
  static unsigned less(const float* a, const float* b) {
    unsigned bits = 0;
    for (int i = 0; i < kLanes; ++i) bits |= unsigned(a[i] < b[i]) << i;
    return bits;
  }
  static unsigned at_most(const float* a, const float* b) {
    unsigned bits = 0;
    for (int i = 0; i < kLanes; ++i) bits |= unsigned(a[i] <= b[i]) << i;
    return bits;
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
  static unsigned share(const std::uint32_t* layers, std::uint32_t mask) {
    unsigned bits = 0;
    for (int i = 0; i < kLanes; ++i) bits |= unsigned((layers[i] & mask) != 0) << i;
    return bits;
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

const Kernels& scalar_kernels() {
  static constexpr Kernels kKernels = make_kernels<Scalar>();
  return kKernels;
}

}  // namespace sightline::culling
