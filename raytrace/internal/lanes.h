// Internal: numbers side by side in plain C++, for code of every processor. The files of kernels for some processors
// alone must not include it: see kernels.h.
#pragma once

#include <cmath>
#include <limits>

namespace sightline::raytrace {

template <class Number, int kCount>
struct Lanes {
  Number v[kCount];
  static Lanes load(const Number* a) {
    return each([&](int i) { return a[i]; });
  }
  static Lanes spread(Number a) {
    return each([&](int) { return a; });
  }
  void store(Number* out) const {
    for (int i = 0; i < kCount; ++i) out[i] = v[i];
  }
  template <class Of>
  static Lanes each(const Of& of) {
    Lanes result;
    for (int i = 0; i < kCount; ++i) result.v[i] = Number(of(i));
    return result;
  }
  template <class Of>
  static unsigned bits(const Of& of) {
    unsigned result = 0;
    for (int i = 0; i < kCount; ++i) result |= unsigned(of(i)) << i;
    return result;
  }

  friend Lanes operator+(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return a.v[i] + b.v[i]; });
  }
  friend Lanes operator-(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return a.v[i] - b.v[i]; });
  }
  friend Lanes operator*(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return a.v[i] * b.v[i]; });
  }
  friend Lanes operator/(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return a.v[i] / b.v[i]; });
  }
  friend Lanes operator-(const Lanes& a) {
    return each([&](int i) { return -a.v[i]; });
  }
  /// As the processor's vector instructions do: b when neither is the greater.
  friend Lanes most(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return a.v[i] > b.v[i] ? a.v[i] : b.v[i]; });
  }
  friend Lanes least(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return a.v[i] < b.v[i] ? a.v[i] : b.v[i]; });
  }
  friend Lanes magnitude(const Lanes& a) {
    return each([&](int i) { return std::fabs(a.v[i]); });
  }
  /// Magnitudes of a with the signs of b; a must not have any.
  friend Lanes with_signs(const Lanes& a, const Lanes& b) {
    return each([&](int i) { return std::copysign(a.v[i], b.v[i]); });
  }
  /// The lowest of some lanes, at least one.
  friend Number lowest_of(const Lanes& a, unsigned which) {
    Number result = std::numeric_limits<Number>::infinity();
    for (int i = 0; i < kCount; ++i)
      if ((which >> i & 1u) != 0 && a.v[i] < result) result = a.v[i];
    return result;
  }
  friend Number highest(const Lanes& a, unsigned which) {
    Number result = -std::numeric_limits<Number>::infinity();
    for (int i = 0; i < kCount; ++i)
      if ((which >> i & 1u) != 0 && a.v[i] > result) result = a.v[i];
    return result;
  }
  // A bit per lane.
  friend unsigned signs(const Lanes& a) {
    return bits([&](int i) { return std::signbit(a.v[i]); });
  }
  friend unsigned at_most(const Lanes& a, const Lanes& b) {
    return bits([&](int i) { return a.v[i] <= b.v[i]; });
  }
  friend unsigned less(const Lanes& a, const Lanes& b) {
    return bits([&](int i) { return a.v[i] < b.v[i]; });
  }
  friend unsigned equal(const Lanes& a, const Lanes& b) {
    return bits([&](int i) { return a.v[i] == b.v[i]; });
  }
};

}  // namespace sightline::raytrace
