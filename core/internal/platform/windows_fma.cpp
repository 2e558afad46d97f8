// fma() and fmaf() that round once, as C asks. MinGW's round twice, and the culler's and the tracer's promises rest on
// it. A program takes these instead of those of its C library, since they are linked first.

#include <cmath>
#include <cstdint>
#include <cstring>

namespace {

bool has_instruction() {
  static const bool has = __builtin_cpu_supports("fma");
  return has;
}

__attribute__((target("fma"))) double by_instruction(double a, double b, double c) {
  return __builtin_fma(a, b, c);
}
__attribute__((target("fma"))) float by_instruction(float a, float b, float c) {
  return __builtin_fmaf(a, b, c);
}

struct Sum {
  double value, error;  // that was rounded away
};

Sum sum_of(double a, double b) {
  const double value = a + b, part = value - a;
  return {value, (a - (value - part)) + (b - part)};
}

Sum product_of(double a, double b) {
  constexpr double kSplit = 134217729.0;  // 2^27 + 1
  const double value = a * b, wide_a = kSplit * a, wide_b = kSplit * b;
  const double high_a = wide_a - (wide_a - a), high_b = wide_b - (wide_b - b), low_a = a - high_a, low_b = b - high_b;
  return {value, ((high_a * high_b - value) + high_a * low_b + low_a * high_b) + low_a * low_b};
}

/// The sum, or its neighbour with an odd last bit where it is not exact: so rounding it again loses nothing.
double sum_to_odd(double a, double b) {
  const auto [value, error] = sum_of(a, b);
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  if (error == 0.0 || bits & 1) return value;
  return std::nextafter(value, error > 0.0 ? HUGE_VAL : -HUGE_VAL);
}

/// Boldo and Melquiond 2008, for processors without the instruction; not near overflow and underflow.
double by_sums(double a, double b, double c) {
  const Sum product = product_of(a, b), low = sum_of(c, product.error), high = sum_of(product.value, low.value);
  if (!std::isfinite(high.value)) return a * b + c;
  return high.value + sum_to_odd(low.error, high.error);
}

}  // namespace

extern "C" double fma(double a, double b, double c) {
  return has_instruction() ? by_instruction(a, b, c) : by_sums(a, b, c);
}

extern "C" float fmaf(float a, float b, float c) {
  return has_instruction() ? by_instruction(a, b, c) : float(sum_to_odd(double(a) * double(b), double(c)));
}
