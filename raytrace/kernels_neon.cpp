// The kernels for NEON: eight lanes are two registers, packets four.
#include "sightline/core/internal/simd128.h"
#include "sightline/raytrace/internal/packet_impl.h"

namespace sightline::raytrace {
namespace {

using core::Double2;
struct PacketForm : BlockForm<core::Registers<core::Float4, kLanes / 4>> {
  using Wide = core::Registers<core::Float4, kPacket / 4>;
  using Eight = core::Registers<Double2, 4>;
  using Mask = core::Registers<core::Mask2, 4>;

  static Eight max(const Eight& x, const Eight& y) { return most(y, x); }
  static Eight min(const Eight& x, const Eight& y) { return least(y, x); }
  static Eight select(const Mask& m, const Eight& x, const Eight& y) { return choose(m, x, y); }
  static Eight root(const Eight& x) { return core::root(x); }
  static Eight fused(const Eight& x, const Eight& y, const Eight& z) { return core::fused(x, y, z); }
  static Eight magnitude(const Eight& x) { return core::magnitude(x); }
  static Eight with_sign(const Eight& x, const Eight& sign) { return with_signs(x, sign); }
  static Mask negative(const Eight& x) { return core::negative(x); }
  static Mask every() { return Mask::of_bits(0xff); }
  static unsigned bits(const Mask& m) { return m; }
  static void store(double* p, unsigned which, const Eight& x) {
    choose(Mask::of_bits(which), x, Eight::load(p)).store(p);
  }
  static Eight inverse_power_of_two(const Eight& x) {
    return Eight::each([&](int i) {
      const int64x2_t exponent = vandq_s64(vreinterpretq_s64_f64(x.q[i].v), vdupq_n_s64(kExponent));
      return Double2{vreinterpretq_f64_s64(vsubq_s64(vdupq_n_s64(kOneOver), exponent))};
    });
  }
  /// Rows of eight numbers become columns from `first` on.
  static void transpose(const double* rows, double* const* columns, int first) {
    for (int row = 0; row < 8; row += 2)
      for (int column = 0; column < 8; column += 2) {
        const double* const block = rows + 8 * row + column;
        const Double2 a = Double2::load(block), b = Double2::load(block + 8);
        firsts(a, b).store(columns[column] + first + row);
        seconds(a, b).store(columns[column + 1] + first + row);
      }
  }
  /// About a third of the exponent.
  static Eight rough_cube_root(const Eight& x) {
    return Eight::each([&](int i) {
      const uint32x2_t high = vshrn_n_u64(vreinterpretq_u64_f64(x.q[i].v), 32);
      const uint32x2_t third = vshrn_n_u64(vmull_n_u32(high, std::uint32_t(kThird)), 32);
      const uint32x2_t sum = vadd_u32(third, vdup_n_u32(std::uint32_t(kTwoThirds)));
      return Double2{vreinterpretq_f64_u64(vshll_n_u32(sum, 32))};
    });
  }
};

}  // namespace

const Kernels& neon_kernels() {
  static constexpr Kernels kKernels = make_kernels<PacketForm>();
  return kKernels;
}
const PacketKernels& neon_packet_kernels() {
  static constexpr PacketKernels kKernels = make_packet_kernels<PacketForm>();
  return kKernels;
}

}  // namespace sightline::raytrace
