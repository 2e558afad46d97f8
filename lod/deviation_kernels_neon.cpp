// The kernels for NEON.
#include "sightline/core/internal/simd128.h"
#include "sightline/lod/internal/deviation_kernels_impl.h"

namespace sightline::lod {
namespace {

using core::Double2;

struct Neon {
  using Four = core::Registers<Double2, 2>;
  using Floats = core::Registers<core::Float4, kBalls / 4>;

  static Four choose(const Four& a, const Four& b, const Four& where_less, const Four& otherwise) {
    return core::choose(less(a, b), where_less, otherwise);
  }
  static void load(const Corner* c, Four& x, Four& y, Four& z) {
    for (int i = 0; i < 2; ++i, c += 2) {
      const Double2 first = Double2::load(&c[0].x), second = Double2::load(&c[1].x);
      x.q[i] = firsts(first, second), y.q[i] = seconds(first, second);
      z.q[i] = firsts(Double2::load(&c[0].z), Double2::load(&c[1].z));
    }
  }
  static double largest(const Four& a) {
    double lanes[kLanes], largest = -std::numeric_limits<double>::infinity();
    a.store(lanes);
    for (const double d : lanes) largest = d > largest ? d : largest;
    return largest;
  }
  static void copy(const Corner& from, Corner& to) { Four::load(&from.x).store(&to.x); }
  static void between(const Corner& a, const Corner& b, double t, Corner& to) {
    const Four from = Four::load(&a.x);
    (from + Four::spread(t) * (Four::load(&b.x) - from)).store(&to.x);
  }

  static std::uint32_t near_ones(const Balls& balls, const float* point, float most) {
    const Floats x = Floats::load(balls.x) - Floats::spread(point[0]);
    const Floats y = Floats::load(balls.y) - Floats::spread(point[1]);
    const Floats z = Floats::load(balls.z) - Floats::spread(point[2]);
    const Floats sum = Floats::load(balls.radius) + Floats::spread(most);
    const Floats reach = core::most(sum, Floats::spread(0.0f));
    return less((x * x + y * y) + z * z, reach * reach);
  }
};

}  // namespace

const DeviationKernels& neon_deviation_kernels() {
  static constexpr DeviationKernels kKernels = make_deviation_kernels<Neon>();
  return kKernels;
}

}  // namespace sightline::lod
