// Internal: eight floats side by side, and the answers of eight comparisons. Two vectors of four where the compiler
// has vector types (GCC, Clang), plain arrays elsewhere; the same IEEE operations, lane by lane, in either form.
#pragma once

#include <cstdint>
#include <cstring>

#include "sightline/culling/frustum_test.h"

namespace sightline::culling {

#if defined(__GNUC__)

using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));
struct FloatLanes {
  Float4 low, high;
};
/// All ones or all zeros per lane (or, after & with a value, that value or zero).
struct MaskLanes {
  Int4 low, high;
};

inline FloatLanes load(const float* p) {
  FloatLanes v;
  std::memcpy(&v.low, p, sizeof(v.low));
  std::memcpy(&v.high, p + 4, sizeof(v.high));
  return v;
}
inline FloatLanes spread(float x) {
  return {Float4{x, x, x, x}, Float4{x, x, x, x}};
}
inline MaskLanes spread(std::int32_t x) {
  return {Int4{x, x, x, x}, Int4{x, x, x, x}};
}
inline FloatLanes operator*(FloatLanes a, FloatLanes b) {
  return {a.low * b.low, a.high * b.high};
}
inline FloatLanes operator+(FloatLanes a, FloatLanes b) {
  return {a.low + b.low, a.high + b.high};
}
inline MaskLanes operator<(FloatLanes a, FloatLanes b) {
  return {a.low < b.low, a.high < b.high};
}
inline MaskLanes operator>=(FloatLanes a, FloatLanes b) {
  return {a.low >= b.low, a.high >= b.high};
}
inline MaskLanes operator|(MaskLanes a, MaskLanes b) {
  return {a.low | b.low, a.high | b.high};
}
inline MaskLanes operator&(MaskLanes a, MaskLanes b) {
  return {a.low & b.low, a.high & b.high};
}
inline MaskLanes operator~(MaskLanes a) {
  return {~a.low, ~a.high};
}
inline void store(MaskLanes v, std::uint32_t* p) {
  std::memcpy(p, &v.low, sizeof(v.low));
  std::memcpy(p + 4, &v.high, sizeof(v.high));
}
/// One bit per lane, of a mask of all ones and zeros.
inline unsigned bits(MaskLanes v) {
  const Int4 lane_bits = (v.low & Int4{1, 2, 4, 8}) | (v.high & Int4{16, 32, 64, 128});
  std::uint64_t halves[2];
  std::memcpy(halves, &lane_bits, sizeof(halves));
  const std::uint64_t both = halves[0] | halves[1];
  return unsigned(both | both >> 32);
}

#else

struct FloatLanes {
  float v[kLanes];
};
struct MaskLanes {
  std::int32_t v[kLanes];
};

template <class Result, class Op>
inline Result per_lane(const Op& op) {
  Result r;
  for (int i = 0; i < kLanes; ++i) r.v[i] = op(i);
  return r;
}
inline FloatLanes load(const float* p) {
  return per_lane<FloatLanes>([&](int i) { return p[i]; });
}
inline FloatLanes spread(float x) {
  return per_lane<FloatLanes>([&](int) { return x; });
}
inline MaskLanes spread(std::int32_t x) {
  return per_lane<MaskLanes>([&](int) { return x; });
}
inline FloatLanes operator*(const FloatLanes& a, const FloatLanes& b) {
  return per_lane<FloatLanes>([&](int i) { return a.v[i] * b.v[i]; });
}
inline FloatLanes operator+(const FloatLanes& a, const FloatLanes& b) {
  return per_lane<FloatLanes>([&](int i) { return a.v[i] + b.v[i]; });
}
inline MaskLanes operator<(const FloatLanes& a, const FloatLanes& b) {
  return per_lane<MaskLanes>([&](int i) { return a.v[i] < b.v[i] ? -1 : 0; });
}
inline MaskLanes operator>=(const FloatLanes& a, const FloatLanes& b) {
  return per_lane<MaskLanes>([&](int i) { return a.v[i] >= b.v[i] ? -1 : 0; });
}
inline MaskLanes operator|(const MaskLanes& a, const MaskLanes& b) {
  return per_lane<MaskLanes>([&](int i) { return a.v[i] | b.v[i]; });
}
inline MaskLanes operator&(const MaskLanes& a, const MaskLanes& b) {
  return per_lane<MaskLanes>([&](int i) { return a.v[i] & b.v[i]; });
}
inline MaskLanes operator~(const MaskLanes& a) {
  return per_lane<MaskLanes>([&](int i) { return ~a.v[i]; });
}
inline void store(const MaskLanes& v, std::uint32_t* p) {
  std::memcpy(p, v.v, sizeof(v.v));
}
inline unsigned bits(const MaskLanes& v) {
  unsigned set = 0;
  for (int i = 0; i < kLanes; ++i) set |= v.v[i] != 0 ? 1u << i : 0u;
  return set;
}

#endif

}  // namespace sightline::culling
