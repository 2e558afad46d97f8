// The plain twin of the wider kernels.
#include "sightline/lod/internal/deviation_kernels_impl.h"

namespace sightline::lod {
namespace {

struct Four {
  double d[kLanes];

  static Four spread(double x) { return {{x, x, x, x}}; }
  void store(double* p) const {
    for (int i = 0; i < kLanes; ++i) p[i] = d[i];
  }
};

template <class Operation>
Four each(const Four& a, const Four& b, const Operation& operation) {
  return {{operation(a.d[0], b.d[0]), operation(a.d[1], b.d[1]), operation(a.d[2], b.d[2]), operation(a.d[3], b.d[3])}};
}
Four operator+(const Four& a, const Four& b) {
  return each(a, b, [](double x, double y) { return x + y; });
}
Four operator-(const Four& a, const Four& b) {
  return each(a, b, [](double x, double y) { return x - y; });
}
Four operator*(const Four& a, const Four& b) {
  return each(a, b, [](double x, double y) { return x * y; });
}
Four least(const Four& a, const Four& b) {
  return each(a, b, [](double x, double y) { return x < y ? x : y; });
}
Four most(const Four& a, const Four& b) {
  return each(a, b, [](double x, double y) { return x > y ? x : y; });
}
unsigned less(const Four& a, const Four& b) {
  unsigned bits = 0;
  for (int i = 0; i < kLanes; ++i) bits |= unsigned(a.d[i] < b.d[i]) << i;
  return bits;
}

struct Scalar {
  using Four = lod::Four;

  static Four choose(const Four& a, const Four& b, const Four& where_less, const Four& otherwise) {
    Four chosen = otherwise;
    for (int i = 0; i < kLanes; ++i)
      if (a.d[i] < b.d[i]) chosen.d[i] = where_less.d[i];
    return chosen;
  }
  static void load(const Corner* c, Four& x, Four& y, Four& z) {
    x = {{c[0].x, c[1].x, c[2].x, c[3].x}};
    y = {{c[0].y, c[1].y, c[2].y, c[3].y}};
    z = {{c[0].z, c[1].z, c[2].z, c[3].z}};
  }
  static double largest(const Four& a) {
    double largest = a.d[0];
    for (const double d : a.d) largest = d > largest ? d : largest;
    return largest;
  }
  static void copy(const Corner& from, Corner& to) { to = from; }
  static void between(const Corner& a, const Corner& b, double t, Corner& to) {
    to = {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z), 0.0};
  }

  static std::uint32_t near_ones(const Balls& balls, const float* point, float most) {
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < kBalls; ++i) {
      const float x = balls.x[i] - point[0], y = balls.y[i] - point[1], z = balls.z[i] - point[2];
      const float sum = balls.radius[i] + most, reach = sum > 0.0f ? sum : 0.0f;
      bits |= std::uint32_t(x * x + y * y + z * z < reach * reach) << i;
    }
    return bits;
  }
};

}  // namespace

const DeviationKernels& scalar_deviation_kernels() {
  static constexpr DeviationKernels kKernels = make_deviation_kernels<Scalar>();
  return kKernels;
}

}  // namespace sightline::lod
