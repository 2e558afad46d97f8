// The plain twin of the wider kernels.
#include <cmath>

#include "sightline/raytrace/internal/lanes.h"
#include "sightline/raytrace/internal/packet_impl.h"

namespace sightline::raytrace {
namespace {

using ScalarWide = Lanes<float, kPacket>;
using ScalarEight = Lanes<double, 8>;

/// A bit for each of eight doubles.
struct ScalarMask {
  unsigned m;
  ScalarMask(unsigned bits = 0) : m(bits & 0xffu) {}
};
inline ScalarMask operator&(ScalarMask a, ScalarMask b) {
  return {a.m & b.m};
}
inline ScalarMask operator|(ScalarMask a, ScalarMask b) {
  return {a.m | b.m};
}
inline ScalarMask operator^(ScalarMask a, ScalarMask b) {
  return {a.m ^ b.m};
}
inline ScalarMask operator~(ScalarMask a) {
  return {~a.m};
}
inline bool any(ScalarMask a) {
  return a.m != 0;
}

struct Scalar : BlockForm<Lanes<float, kLanes>> {
  using Wide = ScalarWide;
  using Eight = ScalarEight;
  using Mask = ScalarMask;

  static Eight max(const Eight& a, const Eight& b) {
    return Eight::each([&](int i) { return larger(a.v[i], b.v[i]); });
  }
  static Eight min(const Eight& a, const Eight& b) {
    return Eight::each([&](int i) { return smaller(a.v[i], b.v[i]); });
  }
  static Eight select(Mask m, const Eight& a, const Eight& b) {
    return Eight::each([&](int i) { return (m.m >> i & 1u) != 0 ? a.v[i] : b.v[i]; });
  }
  static Eight root(const Eight& a) {
    return Eight::each([&](int i) { return std::sqrt(a.v[i]); });
  }
  static Eight fused(const Eight& a, const Eight& b, const Eight& c) {
    return Eight::each([&](int i) { return std::fma(a.v[i], b.v[i], c.v[i]); });
  }
  static Eight magnitude(const Eight& a) {
    return Eight::each([&](int i) { return std::fabs(a.v[i]); });
  }
  static Eight with_sign(const Eight& a, const Eight& sign) {
    return Eight::each([&](int i) { return std::copysign(a.v[i], sign.v[i]); });
  }
  static Mask negative(const Eight& a) { return signs(a); }
  static Mask every() { return 0xffu; }
  static unsigned bits(Mask m) { return m.m; }
  static void store(double* p, unsigned which, const Eight& a) {
    for (int i = 0; i < 8; ++i)
      if ((which >> i & 1u) != 0) p[i] = a.v[i];
  }
  static Eight inverse_power_of_two(const Eight& a) {
    return Eight::each([&](int i) { return raytrace::inverse_power_of_two(a.v[i]); });
  }
  /// Rows of eight numbers become columns from `first` on.
  static void transpose(const double* rows, double* const* columns, int first) {
    for (int row = 0; row < 8; ++row)
      for (int column = 0; column < 8; ++column) columns[column][first + row] = rows[8 * row + column];
  }
  /// About a third of the exponent.
  static Eight rough_cube_root(const Eight& a) {
    return Eight::each([&](int i) {
      DoubleBits u;
      u.value = a.v[i];
      u.bits = (((u.bits >> 32) * kThird >> 32) + kTwoThirds) << 32;
      return u.value;
    });
  }
};

}  // namespace

const Kernels& scalar_kernels() {
  static constexpr Kernels kKernels = make_kernels<Scalar>();
  return kKernels;
}
const PacketKernels& scalar_packet_kernels() {
  static constexpr PacketKernels kKernels = make_packet_kernels<Scalar>();
  return kKernels;
}

}  // namespace sightline::raytrace
