// Internal: registers of 128 bits, with one name for each operation of NEON and of WebAssembly's SIMD128. For files of
// kernels; lies in the anonymous namespace of each, so that every instance is local to the file.
//
// least() and most() answer as a comparison does, with the second where neither is less or more. Both processors' own
// minimum and maximum treat NaN and the signs of zero otherwise.
#pragma once

#include <limits>
#include <utility>

#ifdef SIGHTLINE_WASM_KERNELS
#include "sightline/core/internal/simd128_wasm.h"
#else
#include "sightline/core/internal/simd128_neon.h"
#endif

namespace sightline::core {
namespace {

/// Registers side by side, with the operations that theirs are.
template <class Register, int kCount>
struct Registers {
  Register q[kCount];

  /// Makes one of each register.
  template <class Of>
  static auto each(const Of& of) {
    return each(of, kPlaces);
  }
  template <class Number>
  static Registers load(const Number* a) {
    return each([&](int i) { return Register::load(a + i * Register::kLanes); });
  }
  template <class Number>
  static Registers spread(Number a) {
    return each([&](int) { return Register::spread(a); });
  }
  template <class Number>
  void store(Number* out) const {
    for (int i = 0; i < kCount; ++i) q[i].store(out + i * Register::kLanes);
  }
  /// For masks: a bit per lane, and back.
  operator unsigned() const requires(Register::kIsMask) { return bits(kPlaces); }
  static Registers of_bits(unsigned bits) {
    return each([&](int i) { return Register::of_bits(bits >> i * Register::kLanes); });
  }

 private:
  static constexpr std::make_integer_sequence<int, kCount> kPlaces{};
  template <class Of, int... kAt>
  static auto each(const Of& of, std::integer_sequence<int, kAt...>) {
    return Registers<decltype(of(0)), kCount>{{of(kAt)...}};
  }
  template <int... kAt>
  unsigned bits(std::integer_sequence<int, kAt...>) const {
    return bits_of(q[kAt]...);
  }
};

template <class Register, int kCount>
inline auto operator+(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return a.q[i] + b.q[i]; });
}
template <class Register, int kCount>
inline auto operator-(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return a.q[i] - b.q[i]; });
}
template <class Register, int kCount>
inline auto operator*(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return a.q[i] * b.q[i]; });
}
template <class Register, int kCount>
inline auto operator/(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return a.q[i] / b.q[i]; });
}
template <class Register, int kCount>
inline auto operator&(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return a.q[i] & b.q[i]; });
}
template <class Register, int kCount>
inline auto operator|(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return a.q[i] | b.q[i]; });
}
template <class Register, int kCount>
inline auto operator^(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return a.q[i] ^ b.q[i]; });
}
template <class Register, int kCount>
inline auto operator-(const Registers<Register, kCount>& a) {
  return a.each([&](int i) { return -a.q[i]; });
}
template <class Register, int kCount>
inline auto operator~(const Registers<Register, kCount>& a) {
  return a.each([&](int i) { return ~a.q[i]; });
}
template <class Register, int kCount>
inline auto least(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return least(a.q[i], b.q[i]); });
}
template <class Register, int kCount>
inline auto most(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return most(a.q[i], b.q[i]); });
}
template <class Register, int kCount>
inline auto less(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return less(a.q[i], b.q[i]); });
}
template <class Register, int kCount>
inline auto at_most(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return at_most(a.q[i], b.q[i]); });
}
template <class Register, int kCount>
inline auto equal(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return equal(a.q[i], b.q[i]); });
}
template <class Register, int kCount>
inline auto share_bits(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return share_bits(a.q[i], b.q[i]); });
}
template <class Register, int kCount>
inline auto with_signs(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return with_signs(a.q[i], b.q[i]); });
}
template <class Register, int kCount>
inline auto root(const Registers<Register, kCount>& a) {
  return a.each([&](int i) { return root(a.q[i]); });
}
template <class Register, int kCount>
inline auto magnitude(const Registers<Register, kCount>& a) {
  return a.each([&](int i) { return magnitude(a.q[i]); });
}
template <class Register, int kCount>
inline auto negative(const Registers<Register, kCount>& a) {
  return a.each([&](int i) { return negative(a.q[i]); });
}
template <class Mask, class Register, int kCount>
inline auto choose(const Registers<Mask, kCount>& m, const Registers<Register, kCount>& a,
                   const Registers<Register, kCount>& b) {
  return a.each([&](int i) { return choose(m.q[i], a.q[i], b.q[i]); });
}

template <class Register, int kCount>
inline auto fused(const Registers<Register, kCount>& a, const Registers<Register, kCount>& b,
                  const Registers<Register, kCount>& c) {
  return a.each([&](int i) { return fused(a.q[i], b.q[i], c.q[i]); });
}
/// A bit per sign.
template <class Register, int kCount>
inline unsigned signs(const Registers<Register, kCount>& a) {
  return negative(a);
}
template <class Mask, int kCount>
inline bool any(const Registers<Mask, kCount>& m) {
  return unsigned(m) != 0;
}
/// The least and the greatest of some lanes, at least one, none of them NaN.
template <int kCount>
inline float lowest_of(const Registers<Float4, kCount>& a, unsigned lanes) {
  const auto others = a.spread(std::numeric_limits<float>::infinity());
  const auto chosen = choose(Registers<Mask4, kCount>::of_bits(lanes), a, others);
  Float4 r = chosen.q[0];
  for (int i = 1; i < kCount; ++i) r = least(r, chosen.q[i]);
  return least_lane(r);
}
template <int kCount>
inline float highest(const Registers<Float4, kCount>& a, unsigned lanes) {
  const auto others = a.spread(-std::numeric_limits<float>::infinity());
  const auto chosen = choose(Registers<Mask4, kCount>::of_bits(lanes), a, others);
  Float4 r = chosen.q[0];
  for (int i = 1; i < kCount; ++i) r = most(r, chosen.q[i]);
  return most_lane(r);
}

}  // namespace
}  // namespace sightline::core
