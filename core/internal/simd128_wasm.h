// Internal: the part of simd128.h for WebAssembly.
#pragma once

#include <cstdint>

#include <wasm_simd128.h>

namespace sightline::core {
namespace {

/// Lanes whose bits are all set, or none.
struct Mask4 {
  static constexpr int kLanes = 4;
  static constexpr bool kIsMask = true;
  v128_t v;
  static Mask4 of_bits(unsigned bits) {
    const v128_t own = wasm_i32x4_const(1, 2, 4, 8);
    return {wasm_i32x4_eq(wasm_v128_and(wasm_i32x4_splat(int(bits)), own), own)};
  }
};
/// A bit per lane.
inline unsigned bits_of(Mask4 a, Mask4 b, Mask4 c, Mask4 d) {
  return unsigned(wasm_i8x16_bitmask(
      wasm_i8x16_narrow_i16x8(wasm_i16x8_narrow_i32x4(a.v, b.v), wasm_i16x8_narrow_i32x4(c.v, d.v))));
}

struct Int4 {
  static constexpr int kLanes = 4;
  static constexpr bool kIsMask = false;
  v128_t v;
  static Int4 load(const void* a) { return {wasm_v128_load(a)}; }
  static Int4 spread(std::int32_t a) { return {wasm_i32x4_splat(a)}; }
  void store(std::uint32_t* out) const { wasm_v128_store(out, v); }

  friend Int4 operator+(Int4 a, Int4 b) { return {wasm_i32x4_add(a.v, b.v)}; }
  friend Int4 operator-(Int4 a, Int4 b) { return {wasm_i32x4_sub(a.v, b.v)}; }
  friend Int4 operator*(Int4 a, Int4 b) { return {wasm_i32x4_mul(a.v, b.v)}; }
  friend Int4 least(Int4 a, Int4 b) { return {wasm_i32x4_min(a.v, b.v)}; }
  friend Int4 most(Int4 a, Int4 b) { return {wasm_i32x4_max(a.v, b.v)}; }
  friend Mask4 equal(Int4 a, Int4 b) { return {wasm_i32x4_eq(a.v, b.v)}; }
  friend Mask4 share_bits(Int4 a, Int4 b) {
    return {wasm_i32x4_ne(wasm_v128_and(a.v, b.v), wasm_i32x4_const_splat(0))};
  }
};
/// SIMD128 has no shift by lanes and no gather.
template <class Of>
v128_t by_lanes(Int4 at, const Of& of) {
  return wasm_i32x4_make(of(0, wasm_i32x4_extract_lane(at.v, 0)), of(1, wasm_i32x4_extract_lane(at.v, 1)),
                         of(2, wasm_i32x4_extract_lane(at.v, 2)), of(3, wasm_i32x4_extract_lane(at.v, 3)));
}
inline Int4 shifted(Int4 a, Int4 count) {
  std::int32_t lanes[4];
  wasm_v128_store(lanes, a.v);
  return {by_lanes(count, [&](int lane, int by) { return lanes[lane] >> by; })};
}
inline Int4 pick(const std::int32_t* table, Int4 at) {
  return {by_lanes(at, [&](int, int place) { return table[place]; })};
}
inline Int4 float_exponents(Int4 a) {
  return {wasm_u32x4_shr(wasm_f32x4_convert_i32x4(a.v), 23)};
}
inline void widen(const std::uint8_t* bytes, Int4& low, Int4& high) {
  const v128_t places = wasm_u16x8_load8x8(bytes);
  low.v = wasm_u32x4_extend_low_u16x8(places), high.v = wasm_u32x4_extend_high_u16x8(places);
}

struct Float4 {
  static constexpr int kLanes = 4;
  static constexpr bool kIsMask = false;
  v128_t v;
  static Float4 load(const float* a) { return {wasm_v128_load(a)}; }
  static Float4 spread(float a) { return {wasm_f32x4_splat(a)}; }
  void store(float* out) const { wasm_v128_store(out, v); }

  friend Float4 operator+(Float4 a, Float4 b) { return {wasm_f32x4_add(a.v, b.v)}; }
  friend Float4 operator-(Float4 a, Float4 b) { return {wasm_f32x4_sub(a.v, b.v)}; }
  friend Float4 operator*(Float4 a, Float4 b) { return {wasm_f32x4_mul(a.v, b.v)}; }
  friend Float4 operator/(Float4 a, Float4 b) { return {wasm_f32x4_div(a.v, b.v)}; }
  friend Float4 root(Float4 a) { return {wasm_f32x4_sqrt(a.v)}; }
  friend Float4 magnitude(Float4 a) { return {wasm_f32x4_abs(a.v)}; }
  friend Float4 least(Float4 a, Float4 b) { return {wasm_f32x4_pmin(b.v, a.v)}; }
  friend Float4 most(Float4 a, Float4 b) { return {wasm_f32x4_pmax(b.v, a.v)}; }
  friend Mask4 less(Float4 a, Float4 b) { return {wasm_f32x4_lt(a.v, b.v)}; }
  friend Mask4 at_most(Float4 a, Float4 b) { return {wasm_f32x4_le(a.v, b.v)}; }
  friend Float4 choose(Mask4 m, Float4 a, Float4 b) { return {wasm_v128_bitselect(a.v, b.v, m.v)}; }
  friend Float4 rounded_down(Float4 a) { return {wasm_f32x4_floor(a.v)}; }
  friend Float4 rounded_up(Float4 a) { return {wasm_f32x4_ceil(a.v)}; }
  friend Int4 to_int(Float4 a) { return {wasm_i32x4_trunc_sat_f32x4(a.v)}; }
  friend Float4 even(Float4 a, Float4 b) { return {wasm_i32x4_shuffle(a.v, b.v, 0, 2, 4, 6)}; }
  friend Float4 odd(Float4 a, Float4 b) { return {wasm_i32x4_shuffle(a.v, b.v, 1, 3, 5, 7)}; }
  friend float least_lane(Float4 a) {
    a = least(even(a, a), odd(a, a));
    return wasm_f32x4_extract_lane(least(a, odd(a, a)).v, 0);
  }
  friend float most_lane(Float4 a) {
    a = most(even(a, a), odd(a, a));
    return wasm_f32x4_extract_lane(most(a, odd(a, a)).v, 0);
  }
};
inline Float4 look_up(const float* table, Int4 at) {
  return {wasm_f32x4_make(table[wasm_i32x4_extract_lane(at.v, 0)], table[wasm_i32x4_extract_lane(at.v, 1)],
                          table[wasm_i32x4_extract_lane(at.v, 2)], table[wasm_i32x4_extract_lane(at.v, 3)])};
}

}  // namespace
}  // namespace sightline::core
